# SPDX-License-Identifier: Apache-2.0
"""What the simulated device reports to."""

from __future__ import annotations

from typing import Protocol

from ..backend import Ended


class Outlet(Protocol):
    """Reports of the device to the gateway, and to the record of the truth."""

    def ended(self, end: Ended) -> None: ...

    def event(self, kind: str, text: str) -> None: ...

    def truth(self, event: str, **fields: object) -> None: ...

    def forget_origin(self) -> None: ...

    def restart_link(self) -> None: ...
