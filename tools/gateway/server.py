# SPDX-License-Identifier: Apache-2.0
"""The program around a session: one link, two threads.

The link thread (the caller of `Server.run`) waits for bytes, for reports of the machine and for the
next deadline, and for nothing else: no file, no lock that is held for long, no command. It
recognises STOP, silence and the end of a connection, and calls `Backend.stop` directly, so that no
command can delay them (section 7, number 2). Commands run in the command thread and may take their
time.
"""

from __future__ import annotations

import queue
import selectors
import signal
import socket
import threading
import time
from collections import deque
from functools import partial
from typing import Callable, Sequence

from .backend import Backend, Ended, Sample
from .executor import Done
from .protocol import LineSplitter, Malformed, parse, write
from .session import SILENCE_S, Session
from .transport import Channel, Port
from .witness import Witness

MAX_UNSENT_SAMPLES_BYTES = 1 << 18  # above this, samples are dropped because the peer does not read
MAX_UNSENT_BYTES = 1 << 20  # above this, the connection is closed
RETRY_S = 1.0
MOST_READS = 64  # reads in a row


class Server:
    def __init__(self, port: Port, backend: Backend, revision: int = 3,
                 witness: Witness | None = None,
                 withholds: Callable[[bytes], bool] = lambda line: False) -> None:
        """`withholds` selects lines that are not sent, for a gateway that breaks its promises."""
        self._port = port
        self._withholds = withholds
        self._backend = backend
        self._witness = witness or Witness()
        self._selector = selectors.DefaultSelector()
        self._posted: deque[Callable[[], None]] = deque()
        self._wake_read, self._wake_write = socket.socketpair()
        self._wake_read.setblocking(False)
        self._wake_write.setblocking(False)
        self._work: queue.SimpleQueue[tuple[Callable[[], object], Done] | None] = queue.SimpleQueue()
        self._channel: Channel | None = None
        self._splitter = LineSplitter()
        self._unsent = bytearray()
        self._uncounted = 0  # bytes that were not yet reported to the witness
        self._ending = False
        self._retry_s = 0.0
        self._session = Session(backend, self, revision, self._witness)

    # --- for the main program ---

    def run(self, ready: Callable[[], None] = lambda: None) -> None:
        """Calls `ready` when daemons may connect. Returns after end() was called. A session that
        may command ends then, and its motion with it."""
        self._backend.open(self)
        worker = threading.Thread(target=self._commands, name="commands", daemon=True)
        worker.start()
        self._selector.register(self._wake_read, selectors.EVENT_READ)
        listening = self._port.fileno()
        if listening is not None:
            self._selector.register(listening, selectors.EVENT_READ)
        try:
            ready()
            while not self._ending:
                self._turn()
        finally:
            self._shut_down(worker)

    def end(self) -> None:
        """May be called from any thread and from a signal handler."""
        self._ending = True
        self._wake()

    def hang_up(self) -> None:
        """May be called from any thread. The connection ends as if the gateway had restarted."""
        self._post(self._hang_up)

    def end_on_signals(self) -> None:
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, lambda *_: self.end())

    # --- Host: for the session ---

    def now_s(self) -> float:
        return time.monotonic()

    def send(self, line: bytes) -> None:
        if self._channel is not None and not self._withholds(line):
            self._unsent += line

    def send_samples(self, line: bytes) -> None:
        if len(self._unsent) < MAX_UNSENT_SAMPLES_BYTES:
            self.send(line)

    def run_command(self, work: Callable[[], object], done: Done) -> None:
        self._work.put((work, done))

    # --- Listener: for the back end, from any thread ---

    def samples(self, samples: Sequence[Sample]) -> None:
        self._post(lambda: self._session.samples(samples))

    def ended(self, end: Ended) -> None:
        self._post(lambda: self._session.ended(end))

    def event(self, kind: str, text: str) -> None:
        self._post(lambda: self._session.event(kind, text))

    def origin_changed(self, origin: str, text: str) -> None:
        self._post(lambda: self._session.origin_changed(origin, text))

    # --- the command thread ---

    def _commands(self) -> None:
        while (item := self._work.get()) is not None:
            work, done = item
            result, error = _call(work)
            self._post(partial(done, result, error))

    # --- the link thread ---

    def _turn(self) -> None:
        self._flush()
        deadline_s = min(self._session.deadline_s(), self.now_s() + 1.0)
        if self._port.fileno() is None and self._channel is None:
            deadline_s = min(deadline_s, self._retry_s)
        wait_s = max(0.0, deadline_s - self.now_s())
        readable = {key.fd for key, _ in self._selector.select(wait_s)}
        # What has arrived is read before the peer can be called silent.
        self._read()
        if self._wake_read.fileno() in readable:
            self._drain_wake()
        self._run_posted()
        if self._port.fileno() in readable or self._port.fileno() is None:
            self._accept()
        self._session.tick()

    def _read(self) -> bool:
        """Reads some of what has arrived. False if there is nothing."""
        if self._channel is None:
            return False
        try:
            data = self._channel.read()
        except OSError:
            data = b""
        if data is None:
            return False
        if not data:
            self._hang_up()
            return False
        self._uncounted += len(data)
        lines = list(self._splitter.feed(data))
        if len(lines) > 1 and any(_is_stop(line) for line in lines):
            self._backend.stop()  # at once; the session counts it when it comes to this line
        for line in lines:
            self._session.received(line)
            self._count(len(line) + 1)  # HELLO counts for the session that it opens
        return True

    def _count(self, most: int) -> None:
        count = min(most, self._uncounted)
        self._uncounted -= count
        self._witness.received_bytes(count)

    def _accept(self) -> None:
        if self._port.fileno() is None and (self._channel or self.now_s() < self._retry_s):
            return
        self._retry_s = self.now_s() + RETRY_S
        channel = self._port.accept()
        if channel is None:
            return
        # a daemon that reconnects at once has closed its old connection
        for _ in range(MOST_READS):
            if not self._read():
                break
        if self._channel is not None:
            if self._session.silent_for_s() < SILENCE_S:
                _turn_away(channel)
                return
            self._hang_up()  # dead, or a port scanner, which must not lock out the daemon
        self._channel = channel
        self._splitter = LineSplitter()
        self._selector.register(channel.fileno(), selectors.EVENT_READ)
        self._session.opened(self._port.restarted)

    def _hang_up(self) -> None:
        channel = self._channel
        if channel is None:
            return
        self._channel = None
        self._session.closed()  # first, because it stops the machine
        self._count(self._uncounted)
        self._unsent.clear()
        self._selector.unregister(channel.fileno())
        channel.close()

    def _flush(self) -> None:
        channel = self._channel
        if channel is None:
            return
        try:
            if self._unsent:
                del self._unsent[:channel.write(bytes(self._unsent))]
        except OSError:
            self._hang_up()
            return
        if len(self._unsent) > MAX_UNSENT_BYTES:
            self._hang_up()
            return
        events = selectors.EVENT_READ | (selectors.EVENT_WRITE if self._unsent else 0)
        self._selector.modify(channel.fileno(), events)

    def _post(self, call: Callable[[], None]) -> None:
        self._posted.append(call)
        self._wake()

    def _run_posted(self) -> None:
        for _ in range(len(self._posted)):
            self._posted.popleft()()

    def _wake(self) -> None:
        try:
            self._wake_write.send(b".")
        except (BlockingIOError, OSError):
            pass  # full: the thread wakes anyway; closed: there is no thread to wake

    def _drain_wake(self) -> None:
        try:
            while self._wake_read.recv(4096):
                pass
        except BlockingIOError:
            pass

    def _shut_down(self, worker: threading.Thread) -> None:
        self._flush()
        self._hang_up()  # stops the machine, if the session may command it
        self._work.put(None)
        worker.join(timeout=2.0)
        self._backend.close()
        self._port.close()
        self._selector.close()
        self._wake_read.close()
        self._wake_write.close()


def _call(work: Callable[[], object]) -> tuple[object, Exception | None]:
    try:
        return work(), None
    except Exception as error:  # any exception of a back end is answered as ERR
        return None, error


def _is_stop(raw: bytes) -> bool:
    if b"STOP" not in raw:
        return False
    try:
        return parse(raw).word == "STOP"
    except Malformed:
        return False


def _turn_away(channel: Channel) -> None:
    try:
        channel.write(write("EVENT", {"kind": "busy", "text": "another daemon is connected"}))
    except OSError:
        pass
    channel.close()
