# SPDX-License-Identifier: Apache-2.0
"""A machine and a specimen with a truth of their own, as a back end of the gateway."""
