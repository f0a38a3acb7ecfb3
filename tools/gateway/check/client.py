# SPDX-License-Identifier: Apache-2.0
"""The daemon's side of the link for the check: sends what it is given and keeps all that
arrives."""

from __future__ import annotations

import socket
import threading
import time
from dataclasses import dataclass
from typing import Callable, Iterable

from ..protocol import Line, LineSplitter, Malformed, parse
from .form import complaints

HEARTBEAT_S = 0.2


class Failed(Exception):
    """A promise was not kept."""


class Skipped(Exception):
    """A check cannot be made here; the text says why."""


@dataclass(frozen=True)
class Received:
    arrived_s: float
    line: Line
    text: str

    @property
    def word(self) -> str:
        return self.line.word

    def answers(self, number: int) -> bool:
        return self.line.command == number


class Client:
    """One connection. With `keep_alive` a separate thread sends HB."""

    def __init__(self, host: str, port: int, patience: float, ill_formed: list[str]) -> None:
        self.patience = patience
        self.keep_alive = True
        self._number = 0
        self._ill_formed = ill_formed
        self._received: list[Received] = []
        self._news = threading.Condition()
        self._sending = threading.Lock()
        self.closed_by_gateway = False
        self._socket = socket.create_connection((host, port), timeout=5.0)
        self._socket.settimeout(None)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._open = True
        self._threads = [threading.Thread(target=work, daemon=True) for work in (self._read, self._beat)]
        for thread in self._threads:
            thread.start()

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        if not self._open:
            return
        self._open = False
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        for thread in self._threads:
            thread.join()
        self._socket.close()

    # --- sending ---

    def send(self, text: str) -> float:
        return self.send_raw(text.encode() + b"\n")

    def send_raw(self, raw: bytes) -> float:
        with self._sending:
            sent_s = time.monotonic()
            self._socket.sendall(raw)
            return sent_s

    def number(self) -> int:
        self._number += 1
        return self._number

    def begin_numbers(self) -> None:
        self._number = 0

    def _beat(self) -> None:
        while self._open:
            time.sleep(HEARTBEAT_S / 4)
            if self.keep_alive and time.monotonic() - self._beaten_s >= HEARTBEAT_S:
                self._beaten_s = time.monotonic()
                try:
                    self.send("HB")
                except OSError:
                    return

    _beaten_s = 0.0

    # --- receiving ---

    def _read(self) -> None:
        splitter = LineSplitter()
        while True:
            try:
                data = self._socket.recv(65536)
            except OSError:
                data = b""
            arrived_s = time.monotonic()
            with self._news:
                for raw in splitter.feed(data):
                    self._take(arrived_s, raw)
                if not data:
                    self.closed_by_gateway = self._open
                self._news.notify_all()
            if not data:
                return

    def _take(self, arrived_s: float, raw: bytes) -> None:
        text = raw.decode("utf-8", "replace")
        self._ill_formed += [f"{why}: {text[:120]}" for why in complaints(raw)]
        try:
            self._received.append(Received(arrived_s, parse(raw), text))
        except Malformed as bad:
            self._ill_formed.append(f"{bad}: {text[:120]}")

    def mark(self) -> int:
        """A position in what was received, from which later calls look on."""
        with self._news:
            return len(self._received)

    def since(self, mark: int, words: Iterable[str] = ()) -> list[Received]:
        wanted = tuple(words)
        with self._news:
            return [r for r in self._received[mark:] if not wanted or r.word in wanted]

    def find(self, mark: int, wanted: Callable[[Received], bool], timeout_s: float) -> Received | None:
        """The first wanted line since the mark. Waits for it."""
        deadline_s = time.monotonic() + timeout_s
        at = mark
        with self._news:
            while True:
                for received in self._received[at:]:
                    if wanted(received):
                        return received
                at = len(self._received)
                left_s = deadline_s - time.monotonic()
                if left_s <= 0 or self.closed_by_gateway:
                    return None
                self._news.wait(left_s)

    def expect(self, what: str, mark: int, wanted: Callable[[Received], bool],
               timeout_s: float) -> Received:
        found = self.find(mark, wanted, timeout_s)
        if found is None:
            raise Failed(f"{what} did not come within {timeout_s:.2g} s; {self.lately(mark)}")
        return found

    def lately(self, mark: int) -> str:
        """For a message: what arrived instead."""
        if self.closed_by_gateway:
            return "the gateway closed the connection"
        lines = [r.text[:100] for r in self.since(mark) if r.word not in ("S", "HB")]
        return "came: " + " | ".join(lines[-4:]) if lines else "nothing came but S and HB"

    # --- commands ---

    def command(self, text: str, number: int | None = None) -> Received:
        """Sends a numbered command and waits for OK or ERR, which must come within 1 s."""
        if number is None:
            number = self.number()
        mark = self.mark()
        self.send(f"#{number} {text}")
        return self.answer(text, number, mark)

    def answer(self, text: str, number: int, mark: int) -> Received:
        return self.expect(f"OK or ERR to `{text[:60]}`", mark,
                           lambda r: r.word in ("OK", "ERR") and r.answers(number),
                           1.0 * self.patience)

    def accepted(self, text: str) -> int:
        """Sends a command that must be accepted, and returns its number."""
        answer = self.command(text)
        if answer.word != "OK":
            raise Failed(f"`{text}` was refused: {answer.text}")
        assert answer.line.command is not None
        return answer.line.command

    def refused(self, text: str, *codes: str) -> None:
        answer = self.command(text)
        if answer.word != "ERR":
            raise Failed(f"`{text}` was accepted, expected ERR code={' or '.join(codes)}")
        code = answer.line.fields.get("code")
        if code not in codes:
            raise Failed(f"`{text}`: expected code={' or '.join(codes)}, found {answer.text}")

    def done(self, number: int, mark: int, timeout_s: float) -> Received:
        return self.expect(f"DONE #{number}", mark, lambda r: r.word == "DONE" and r.answers(number),
                           timeout_s)

    def stop(self) -> Received:
        mark = self.mark()
        self.send("STOP")
        return self.expect("STOPPED", mark, lambda r: r.word == "STOPPED", 3.0 * self.patience)


def seconds(duration_s: float) -> None:
    """Waits, for something that must or must not happen meanwhile."""
    time.sleep(duration_s)
