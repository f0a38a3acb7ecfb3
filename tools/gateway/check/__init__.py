# SPDX-License-Identifier: Apache-2.0
"""Conformance check for gateways: does one keep what docs/frame-link.md promises?"""
