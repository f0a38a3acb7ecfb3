# SPDX-License-Identifier: Apache-2.0
"""The session of one connection (docs/frame-link.md, sections 2, 3 and 6): HELLO, OBSERVE, STOP,
heartbeats and silence. It has no sockets, threads or clock of its own. The link thread calls it."""

from __future__ import annotations

import enum
import math
from typing import Sequence

from . import commands, protocol
from .backend import Backend, Ended, Refused, Sample
from .executor import Executor, Host, refusal
from .protocol import Line, Malformed, Missing, Value, write
from .sample_lines import SampleLines
from .witness import Witness

HEARTBEAT_S = 0.25
SILENCE_S = 1.0
STANDSTILL_POLL_S = 0.005
MAX_REPORTS_PER_S = 20  # about lines that we do not understand


class Kind(enum.Enum):
    NONE = "none"  # neither HELLO nor OBSERVE was received
    COMMAND = "command"
    OBSERVER = "observer"


class Session:
    def __init__(self, backend: Backend, host: Host, revision: int = 3,
                 witness: Witness | None = None) -> None:
        self._backend = backend
        self._host = host
        self._revision = revision
        self._witness = witness or Witness()
        self._samples = SampleLines(self._send_samples)
        self._executor = Executor(backend, host, self._send, self._samples, revision)
        self.kind = Kind.NONE
        self._last_number = 0
        self._stops = 0
        self._heard_s = self._sent_s = host.now_s()
        self._silent = False
        self._reports_s, self._reports = -math.inf, 0

    # --- the connection ---

    def opened(self, restarted: bool = False) -> None:
        """A connection begins. `restarted`: on a serial line that existed before this program
        started."""
        self._heard_s = self._sent_s = self._host.now_s()
        self._silent = False
        self._witness.connection(True)
        self._begin(Kind.NONE)
        if restarted:
            self._send_hello()

    def closed(self) -> None:
        if self.kind is Kind.COMMAND:
            self._backend.stop()
        self._witness.connection(False)
        self._begin(Kind.NONE)

    # --- what the daemon says ---

    def received(self, raw: bytes) -> None:
        """Handles one line without its LF."""
        if not raw.strip(b" \r"):
            return
        try:
            line = protocol.parse(raw)
            self._witness.received_line(line.word, line.command, raw[:200].decode("utf-8", "replace"))
            if line.word == "STOP":
                self._stop(line)
            elif line.command is not None:
                self._command(line, line.command)
            else:
                self._message(line)
            self._heard()
        except Malformed as bad:
            self._malformed(bad)

    def _heard(self) -> None:
        self._heard_s = self._host.now_s()
        self._silent = False

    def _malformed(self, bad: Malformed) -> None:
        self._witness.received_line("", bad.command, str(bad))
        if bad.command is None:
            self._report("syntax", str(bad))
        elif self.kind is Kind.OBSERVER:
            self._refuse(bad.command, "observer", str(bad))
        elif self.kind is Kind.COMMAND or self._revision >= 2:
            self._refuse(bad.command, "syntax", str(bad))

    def _stop(self, line: Line) -> None:
        self._backend.stop()
        self._stops += 1
        self._executor.cancel_motions("STOP came first")
        self._executor.stopping = True
        # section 4 does not allow a number here, but stopping does no harm
        if line.command is not None:
            code = "observer" if self.kind is Kind.OBSERVER else "syntax"
            self._refuse(line.command, code, "STOP carries no number")
        self._answer_stop()

    def _command(self, line: Line, number: int) -> None:
        if self.kind is Kind.OBSERVER:
            self._refuse(number, "observer", "an observer session takes no commands")
        elif self.kind is Kind.NONE:
            if self._revision >= 2:
                self._refuse(number, "not_ready", "say HELLO first")
        else:
            try:
                command = commands.read(line)
                self._check_number(number)
                self._executor.submit(number, command)
            except Missing as missing:
                self._last_number = max(self._last_number, number)
                self._refuse(number, "syntax", str(missing))
            except Refused as refused:
                self._last_number = max(self._last_number, number)
                self._refuse(number, refused.code, refused.text)

    def _check_number(self, number: int) -> None:
        if number <= self._last_number:
            raise Refused("bad_value", f"numbers grow; the last one was #{self._last_number}")
        self._last_number = number

    def _message(self, line: Line) -> None:
        try:
            if line.word == "HELLO":
                self._hello(line)
            elif line.word == "OBSERVE" and self._revision >= 2:
                self._observe(line)
            elif line.word != "HB":
                self._report("unknown", f"the word {line.word}")
        except Missing as missing:
            self._report("syntax", str(missing))

    def _hello(self, line: Line) -> None:
        if self._talks_to_us(line):
            self._open(Kind.COMMAND, 0.0)

    def _observe(self, line: Line) -> None:
        hz = line.real("hz")
        if hz < 0:
            self._report("syntax", "hz must not be negative")
        elif self._talks_to_us(line):
            self._open(Kind.OBSERVER, min(hz, self._backend.capabilities().rate_max_hz))

    def _talks_to_us(self, line: Line) -> bool:
        proto = line.real("proto")
        if line.text("side", "host") != "host":
            self._report("syntax", "side is not host: is this an echo?")
            return False
        if proto == 1:
            return True
        self._give_up()
        self._send_hello()
        return False

    # --- sessions ---

    def _open(self, kind: Kind, hz: float) -> None:
        if kind is Kind.COMMAND or self.kind is Kind.COMMAND:
            self._backend.stop()
        self._begin(kind, hz)
        self._executor.settle()
        self._send_hello()
        self._say("CAPS", dict(self._backend.capabilities().fields(self._revision)))

    def _give_up(self) -> None:
        """The other side speaks another protocol, so any session is over."""
        if self.kind is Kind.COMMAND:
            self._backend.stop()
        self._begin(Kind.NONE)

    def _begin(self, kind: Kind, hz: float = 0.0) -> None:
        self.kind = kind
        self._last_number = 0
        self._stops = 0
        self._executor.begin_session(hz)
        self._witness.session(kind.value)

    def _send_hello(self) -> None:
        who = self._backend.identity()
        fields: dict[str, Value] = {"proto": 1}
        if self._revision >= 2:
            fields["revision"] = self._revision
        fields.update(side="gateway", maker=who.maker, model=who.model, serial=who.serial,
                      version=who.version)
        if self._revision >= 2:
            fields["origin"] = self._backend.origin()
            fields["simulated"] = True if who.simulated else None
        self._say("HELLO", fields)

    # --- what the machine says ---

    def samples(self, samples: Sequence[Sample]) -> None:
        self._samples.add(samples, self._host.now_s())

    def ended(self, end: Ended) -> None:
        self._executor.ended(end)
        self._answer_stop()

    def event(self, kind: str, text: str) -> None:
        if self.kind is not Kind.NONE:
            self._say("EVENT", {"kind": kind, "text": text})

    def origin_changed(self, origin: str, text: str) -> None:
        if self.kind is not Kind.NONE and self._revision >= 2:
            self._say("EVENT", {"kind": "origin", "origin": origin, "text": text})

    # --- time ---

    def tick(self) -> None:
        """Must be called no later than deadline_s(), after everything that has arrived was read."""
        now_s = self._host.now_s()
        self._executor.tick()
        self._answer_stop()
        if self._samples.due_s() <= now_s:
            self._samples.flush()
        if self.kind is Kind.NONE:
            return
        if now_s - self._heard_s >= SILENCE_S and not self._silent:
            self._silence()
        if now_s - self._sent_s >= HEARTBEAT_S:
            self._say("HB", {"t_s": self._backend.state().device_s})

    def deadline_s(self) -> float:
        due_s = self._samples.due_s()
        if self._executor.polls():
            due_s = min(due_s, self._host.now_s() + STANDSTILL_POLL_S)
        if self.kind is not Kind.NONE:
            due_s = min(due_s, self._sent_s + HEARTBEAT_S)
            if not self._silent:
                due_s = min(due_s, self._heard_s + SILENCE_S)
        return due_s

    def silent_for_s(self) -> float:
        return self._host.now_s() - self._heard_s

    def _silence(self) -> None:
        """A silent observer only gets no more samples until it is heard again."""
        self._silent = True
        if self.kind is Kind.COMMAND:
            self._backend.stop()
            self._executor.forget_limits("host silent")
            self._executor.settle()
            self._say("EVENT", {"kind": "watchdog", "text": "host silent for 1 s"})

    def _answer_stop(self) -> None:
        if (not self._executor.stopping or self._executor.moves()
                or self._backend.state().moving):
            return
        self._executor.stopping = False
        self._samples.flush()
        state = self._backend.state()
        self._say("STOPPED", {"stops": self._stops, "force_N": state.force_N,
                                    "travel_mm": state.travel_mm})

    # --- sending ---

    def _send(self, line: bytes) -> None:
        self._sent_s = self._host.now_s()
        self._host.send(line)

    def _send_samples(self, line: bytes) -> None:
        if not (self._silent and self.kind is Kind.OBSERVER):
            self._sent_s = self._host.now_s()
            self._host.send_samples(line)

    def _say(self, word: str, fields: dict[str, Value]) -> None:
        self._send(write(word, fields))

    def _refuse(self, number: int, code: str, text: str) -> None:
        self._send(refusal(number, Refused(code, text)))

    def _report(self, kind: str, text: str) -> None:
        """A gateway of revision 1 reports nothing before a HELLO, so that noise does not answer
        noise."""
        now_s = self._host.now_s()
        if now_s - self._reports_s >= 1.0:
            self._reports_s, self._reports = now_s, 0
        self._reports += 1
        if self._reports <= MAX_REPORTS_PER_S and (self.kind is not Kind.NONE or self._revision >= 2):
            self._say("EVENT", {"kind": kind, "text": text})
