# SPDX-License-Identifier: Apache-2.0
"""Groups samples into `S` lines (docs/frame-link.md, section 5)."""

from __future__ import annotations

import math
from typing import Callable, Sequence

from .backend import Sample
from .protocol import Column, Value, write

LINE_COVERS_S = 0.1  # at most this time per line
_MAX_PER_LINE = 500  # far below 65,536 bytes even with all digits of every number


class SampleLines:
    """Numbers samples and groups them. A line that `send` drops shows as a gap in seq."""

    def __init__(self, send: Callable[[bytes], None]) -> None:
        self._send = send
        self.begin_session()

    def begin_session(self) -> None:
        self._next_seq = 1
        self._hz = 0.0
        self._pending: list[Sample] = []
        self._first_arrived_s = 0.0

    def set_rate(self, hz: float) -> None:
        self.flush()
        self._hz = hz

    def add(self, samples: Sequence[Sample], now_s: float) -> None:
        if self._hz <= 0:
            return  # from a session that is over, or a rate that was not yet answered
        for sample in samples:
            if sample.lost_before:
                self.flush()
                self._next_seq += sample.lost_before
            if not self._pending:
                self._first_arrived_s = now_s
            self._pending.append(sample)
            if len(self._pending) >= self._per_line():
                self.flush()

    def due_s(self) -> float:
        """When the pending samples must be sent at the latest."""
        return self._first_arrived_s + LINE_COVERS_S if self._pending else math.inf

    def flush(self) -> None:
        if not self._pending:
            return
        self._send(write("S", _fields(self._next_seq, self._pending)))
        self._next_seq += len(self._pending)
        self._pending = []

    def _per_line(self) -> int:
        return max(1, min(_MAX_PER_LINE, math.floor(LINE_COVERS_S * self._hz + 1e-9)))


def _fields(seq: int, samples: Sequence[Sample]) -> dict[str, Value]:
    return {
        "seq": seq,
        "n": len(samples),
        "t_s": _column([s.t_s for s in samples]),
        "force_N": _column([None if s.overload else s.force_N for s in samples]),
        "travel_mm": _column([s.travel_mm for s in samples]),
        "flags": _flags(samples),
    }


def _column(values: Sequence[float | None]) -> Column | None:
    return None if all(v is None for v in values) else Column(values)


def _flags(samples: Sequence[Sample]) -> Column | None:
    words = [_flag_word(s) if s.flags_known else None for s in samples]
    if all(word is None for word in words):
        return None
    return Column(words[:1] if len(set(words)) == 1 else words)


def _flag_word(sample: Sample) -> str:
    word = "M" if sample.moving else ""
    word += "F" if sample.force_control else ""
    word += "O" if sample.overload else ""
    return word or "-"
