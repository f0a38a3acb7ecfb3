# SPDX-License-Identifier: Apache-2.0
"""The record of the truth as JSON lines, which a test can read while the machine runs.

Every line has t_s (seconds since the machine began), force_N, travel_mm (true, in the machine's own
coordinates), peak_force_N, moving, session and bytes_received. An event has its name in `event`. An
event of the link has the time at which it came, and the last known state of the machine. Lines
without an event come at most 50 times a second. The last line is the event `summary`.
"""

from __future__ import annotations

import json
import queue
import threading
from typing import Any, Callable, TextIO

from ..witness import Witness

LINES_PER_S = 50


class Truth(Witness):
    """All methods only put something into a queue, which a separate thread writes. So no file ever
    delays the link or the machine."""

    def __init__(self, file: TextIO) -> None:
        self._file = file
        self._queue: queue.SimpleQueue[tuple[str, dict[str, Any]] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._write, name="truth", daemon=True)
        self._book = _Book()
        self.clock: Callable[[], float] = lambda: 0.0  # the machine's seconds
        self._thread.start()

    # --- the machine ---

    def put(self, event: str, **fields: Any) -> None:
        """event "": records only the state of the machine."""
        self._queue.put((event, fields))

    def close(self) -> None:
        self._queue.put(None)
        self._thread.join()

    # --- the link (Witness) ---

    def connection(self, opened: bool) -> None:
        self._put_now("connection_opened" if opened else "connection_closed")

    def session(self, kind: str) -> None:
        self._put_now("session", kind=kind)

    def received_bytes(self, count: int) -> None:
        self.put("bytes", count=count)

    def received_line(self, word: str, command: int | None, text: str) -> None:
        self._put_now("stop_received" if word == "STOP" else "received", word=word, number=command,
                      line=text)

    def _put_now(self, event: str, **fields: Any) -> None:
        self.put(event, t_s=round(self.clock(), 6), **fields)

    # --- the thread ---

    def _write(self) -> None:
        while (item := self._queue.get()) is not None:
            line = self._book.enter(*item)
            if line is not None:
                self._print(line)
        self._print(self._book.summary())
        self._file.close()

    def _print(self, line: dict[str, Any]) -> None:
        self._file.write(json.dumps(line) + "\n")
        self._file.flush()


class _Book:
    """What the lines contain, and the sums."""

    _WORDS = {"STOP": "stops", "HELLO": "hellos", "OBSERVE": "observes", "HB": "life_signs"}

    def __init__(self) -> None:
        self._state: dict[str, Any] = {"t_s": 0.0, "force_N": 0.0, "travel_mm": 0.0,
                                       "peak_force_N": 0.0, "moving": False}
        self._session = "none"
        self._bytes: dict[str, int] = {"none": 0, "command": 0, "observer": 0}
        self._counts = dict.fromkeys(("stops", "hellos", "observes", "commands", "life_signs",
                                      "malformed", "other"), 0)
        self._max_travel_mm = self._motions = 0
        self._stood_after_stop = False
        self._moved_after_stop: bool | None = None

    def enter(self, event: str, fields: dict[str, Any]) -> dict[str, Any] | None:
        if event == "bytes":
            self._bytes[self._session] += fields["count"]
            return None
        state = fields.pop("state", None)
        if state:
            self._see(state)
        if event == "session":
            self._session = fields["kind"]
        if event in ("received", "stop_received"):
            self._count(fields)
        line = {**self._state, "session": self._session, "bytes_received": sum(self._bytes.values())}
        return {**line, "event": event, **fields} if event else line

    def _see(self, state: dict[str, Any]) -> None:
        self._max_travel_mm = state.pop("max_travel_mm")
        self._motions = state.pop("motions")
        turning = state.pop("turning")
        self._state = state
        if self._moved_after_stop is not None:
            self._stood_after_stop = self._stood_after_stop or not state["moving"]
            self._moved_after_stop = self._moved_after_stop or (self._stood_after_stop and turning)

    def _count(self, fields: dict[str, Any]) -> None:
        word = fields["word"]
        if not word:
            self._counts["malformed"] += 1
        elif word in self._WORDS:
            self._counts[self._WORDS[word]] += 1
        else:
            self._counts["commands" if fields["number"] is not None else "other"] += 1
        if word == "STOP":
            self._stood_after_stop, self._moved_after_stop = False, False

    def summary(self) -> dict[str, Any]:
        return {**self._state, "event": "summary", "max_travel_mm": self._max_travel_mm,
                "motions": self._motions, "bytes_received": sum(self._bytes.values()),
                **{f"bytes_{kind}": count for kind, count in self._bytes.items()}, **self._counts,
                "moved_after_last_stop": self._moved_after_stop}
