# SPDX-License-Identifier: Apache-2.0
"""Conformance check for gateways: does a gateway keep what docs/frame-link.md promises?"""
