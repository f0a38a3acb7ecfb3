# SPDX-License-Identifier: Apache-2.0
"""A reference gateway for frame-link/1 revision 3 (docs/frame-link.md, docs/gateway.md)."""

__version__ = "0.1.0"
