# SPDX-License-Identifier: Apache-2.0
"""Orders on their way to the simulated drive."""

from __future__ import annotations

from collections import deque
from typing import Callable


class Orders:
    """Sorted by the step at which they are due, so a STOP overtakes the order of a slow watch."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[int, Callable[[], None]]] = deque()

    def put(self, due: int, call: Callable[[], None]) -> None:
        place = sum(1 for other, _ in self._waiting if other <= due)
        self._waiting.insert(place, (due, call))

    def carry_out(self, step: int) -> None:
        while self._waiting and self._waiting[0][0] <= step:
            self._waiting.popleft()[1]()

    def __bool__(self) -> bool:
        return bool(self._waiting)
