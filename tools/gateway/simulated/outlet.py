# SPDX-License-Identifier: Apache-2.0
"""Whom the simulated device talks to."""

from __future__ import annotations

from typing import Protocol

from ..backend import Ended


class Outlet(Protocol):
    """What the device says: to the gateway, and to the witness of the truth."""

    def ended(self, end: Ended) -> None: ...

    def event(self, kind: str, text: str) -> None: ...

    def truth(self, event: str, **fields: object) -> None: ...

    def forget_origin(self) -> None: ...

    def restart_link(self) -> None: ...
