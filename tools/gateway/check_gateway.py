#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Conformance check for gateways; the same as `lcrig-gateway check`."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from gateway.check.main import main  # noqa: E402

if __name__ == "__main__":
    sys.exit(main())
