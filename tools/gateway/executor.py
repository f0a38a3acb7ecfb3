# SPDX-License-Identifier: Apache-2.0
"""The commands of a session, one at a time: refreshed, judged, carried out, answered, and DONE.

Everything here runs in the link thread, except for what is given to `Host.run_command`, which runs
in the command thread. STOP never waits for any of it: the session calls Backend.stop() itself, and
then `cancel_motions`.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Callable, Mapping, Protocol

from .backend import Backend, Ended, Refused, Window
from .commands import Command, LimitsCommand, RateCommand
from .protocol import Value, write
from .rules import Situation
from .sample_lines import SampleLines

MAX_WAITING = 100
SETTLE_S = 0.5

Done = Callable[[object, "Exception | None"], None]


class Host(Protocol):
    """What a session needs from the program around it. Nothing here blocks."""

    def now_s(self) -> float: ...

    def send(self, line: bytes) -> None: ...

    def send_samples(self, line: bytes) -> None:
        """May drop the line if the peer does not read."""

    def run_command(self, work: Callable[[], object], done: Done) -> None:
        """Calls `work` in the command thread, then `done` with its result in the link thread."""


@dataclass
class _Job:
    number: int | None  # None: our own command, without an answer
    command: Command
    session: int
    cancelled: str = ""  # why a motion must no longer begin


@dataclass
class _Motion:
    number: int
    token: int
    answered: bool = False
    end: Ended | None = None  # set if the end came before the OK was sent
    fault: str = ""  # why the gateway itself ended the motion


class Executor:
    def __init__(self, backend: Backend, host: Host, send: Callable[[bytes], None],
                 samples: SampleLines, revision: int) -> None:
        self._backend = backend
        self._run = host.run_command
        self._now_s = host.now_s
        self._send = send
        self._samples = samples
        self._revision = revision
        self._session = 0
        self._tokens = 0
        self._waiting: deque[_Job] = deque()
        self._job: _Job | None = None
        self._motion: _Motion | None = None
        self._settle_until_s = 0.0
        self._settling = False  # the present job waits for standstill
        self.limits: Window | None = None
        self.stopping = False  # STOP was received and is not yet answered

    def begin_session(self, hz: float) -> None:
        """Forgets limits, motion and waiting commands. Samples come at hz as soon as possible."""
        self._session += 1
        self._waiting.clear()
        self._motion = None
        self.limits = None
        self.stopping = False
        self._samples.begin_session()
        self._submit(_Job(None, RateCommand(hz), self._session))

    def submit(self, number: int, command: Command) -> None:
        if len(self._waiting) >= MAX_WAITING:
            self._refuse(number, Refused("busy", f"{MAX_WAITING} commands wait already"))
            return
        self._submit(_Job(number, command, self._session))

    def cancel_motions(self, why: str) -> None:
        """Motions that have not begun are refused. The caller stops the one under way."""
        self._cancel(lambda command: command.moves, why)

    def forget_limits(self, why: str) -> None:
        """After a fault: the motion under way ends with this fault, and waiting commands neither
        move nor arm."""
        self.limits = None
        if self._motion:
            self._motion.fault = why
        self._cancel(lambda command: command.moves or isinstance(command, LimitsCommand), why)

    def _cancel(self, which: Callable[[Command], bool], why: str) -> None:
        if self._job and which(self._job.command):
            self._job.cancelled = why
        for job in [j for j in self._waiting if which(j.command)]:
            self._waiting.remove(job)
            if job.number is not None:
                self._refuse(job.number, Refused("not_ready", why))

    def settle(self) -> None:
        """The session has just stopped the machine, so commands wait a short time for standstill.
        Otherwise the LIMITS that follow a HELLO would be refused because of a stop of a few
        milliseconds."""
        self._settle_until_s = self._now_s() + SETTLE_S

    def tick(self) -> None:
        if self._settling:
            self._settling = False
            self._judge()

    def polls(self) -> bool:
        """True while something waits for standstill."""
        return self.stopping or self._settling

    def moves(self) -> bool:
        """True if a motion is under way or may still begin."""
        return self._motion is not None or bool(self._job and self._job.command.moves)

    def ended(self, end: Ended) -> None:
        motion = self._motion
        if motion is None or motion.token != end.token:
            return  # from a session that is over
        motion.end = end
        if motion.answered:
            self._done(motion, end)

    def _submit(self, job: _Job) -> None:
        self._waiting.append(job)
        self._begin_next()

    def _begin_next(self) -> None:
        if self._job or not self._waiting:
            return
        self._job = self._waiting.popleft()
        if self._job.number is None:
            self._judge()
        else:
            self._run(self._backend.refresh, self._looked)

    def _looked(self, _: object, error: Exception | None) -> None:
        job = self._job
        assert job is not None
        if error is not None and job.session == self._session:
            self._answer_error(job, error)
            self._finish()
        else:
            self._judge()

    def _judge(self) -> None:
        job = self._job
        assert job is not None
        if job.session != self._session:
            self._finish()
            return
        if job.number is not None and self._must_settle():
            self._settling = True
            return
        try:
            if job.cancelled:
                raise Refused("not_ready", job.cancelled)
            self._tokens += 1
            action = job.command.judge(self._situation(), self._tokens)
        except Exception as error:  # in any case the daemon gets an answer
            self._answer_error(job, error)
            self._finish()
            return
        if job.command.ends_with_done and job.number is not None:
            self._motion = _Motion(job.number, self._tokens)
        self._run(lambda: action(self._backend), self._acted)

    def _must_settle(self) -> bool:
        if self._now_s() < self._settle_until_s and self._backend.state().moving:
            return True
        self._settle_until_s = 0.0
        return False

    def _acted(self, result: object, error: Exception | None) -> None:
        job = self._job
        assert job is not None
        # A motion that began during a STOP, a silence or a change of session must end as well.
        if job.command.moves and (error or job.cancelled or job.session != self._session):
            self._backend.stop()
        if isinstance(job.command, LimitsCommand) and job.cancelled:
            error = error or Refused("not_ready", job.cancelled)
        if job.session == self._session:
            if error is None:
                self._accept(job, result)
            else:
                if job.command.ends_with_done:
                    self._motion = None
                self._answer_error(job, error)
        self._finish()

    def _accept(self, job: _Job, result: object) -> None:
        if isinstance(job.command, LimitsCommand):
            self.limits = job.command.window
        if job.number is not None:
            fields = dict(result) if isinstance(result, Mapping) else {}
            if self._revision < 2:
                fields.pop("origin", None)
            self._send(write("OK", fields, answer_to=job.number))
        if isinstance(job.command, RateCommand):
            self._samples.set_rate(job.command.hz)
        motion = self._motion
        if motion and motion.number == job.number:
            motion.answered = True
            if motion.end:
                self._done(motion, motion.end)

    def _finish(self) -> None:
        self._job = None
        self._begin_next()

    def _done(self, motion: _Motion, end: Ended) -> None:
        """Sends the last sample of the motion first."""
        self._motion = None
        self._samples.flush()
        by_us = motion.fault and end.reason == "stop"
        fields: dict[str, Value] = {
            "reason": "fault" if by_us else end.reason, "force_N": end.force_N,
            "travel_mm": end.travel_mm, "text": motion.fault if by_us else end.text}
        self._send(write("DONE", fields, answer_to=motion.number))

    def _situation(self) -> Situation:
        state = self._backend.state()
        busy = ""
        if self.stopping:
            busy = "STOP is being carried out"
        elif self._motion:
            busy = f"motion #{self._motion.number} is under way"
        elif state.moving:
            busy = "the machine is moving"
        return Situation(self._backend.capabilities(), self.limits, state, busy)

    def _answer_error(self, job: _Job, error: Exception) -> None:
        if job.number is None:
            return
        if not isinstance(error, Refused):
            error = Refused("internal", f"{type(error).__name__}: {error}")
        self._refuse(job.number, error)

    def _refuse(self, number: int, refused: Refused) -> None:
        self._send(refusal(number, refused))


def refusal(number: int, refused: Refused) -> bytes:
    return write("ERR", {"code": refused.code, "text": refused.text}, answer_to=number)
