# SPDX-License-Identifier: Apache-2.0
"""A simulated machine and specimen, which know their true state, as a back end of the gateway."""
