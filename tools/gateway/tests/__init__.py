# SPDX-License-Identifier: Apache-2.0
"""Run from tools/ or any folder below: /usr/bin/python3 -m unittest discover."""
