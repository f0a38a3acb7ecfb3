# SPDX-License-Identifier: Apache-2.0
"""The commands of docs/frame-link.md, section 4: how each is read, judged and given to the
machine."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import Mapping, Self

from . import rules
from .backend import (Backend, HoldForce, Move, MoveToForce, RampForce, Refused, State, Window)
from .protocol import Line, Value
from .rules import Situation, require


@dataclass(frozen=True)
class Command(ABC):
    """`judge` runs in the link thread and may raise Refused. It returns a function for the command
    thread, which may block and returns the fields of the OK."""

    moves = False  # needs LIMITS, and STOP cancels it
    ends_with_done = False

    @classmethod
    def read(cls, line: Line) -> Self:
        """Members have the names of the line's fields. They are numbers unless a class says
        otherwise."""
        return cls(*(line.real(field.name) for field in fields(cls)))

    @abstractmethod
    def judge(self, s: Situation, token: int) -> "Action": ...


class Motion(Command):
    moves = True
    ends_with_done = True


class Action(ABC):
    @abstractmethod
    def __call__(self, backend: Backend) -> Mapping[str, Value]: ...


@dataclass(frozen=True)
class Nothing(Action):
    def __call__(self, backend: Backend) -> Mapping[str, Value]:
        return {}


@dataclass(frozen=True)
class Start(Action):
    motion: Move | MoveToForce | RampForce

    def __call__(self, backend: Backend) -> Mapping[str, Value]:
        backend.start(self.motion)
        return {}


@dataclass(frozen=True)
class StatusCommand(Command):
    def judge(self, s: Situation, token: int) -> Action:
        return Nothing()


@dataclass(frozen=True)
class RateCommand(Command, Action):
    hz: float

    def judge(self, s: Situation, token: int) -> Action:
        fastest_hz = s.capabilities.rate_max_hz
        require(self.hz >= 0, "bad_value", "hz must not be negative")
        require(self.hz <= fastest_hz, "machine_limits", f"faster than rate_max_hz={fastest_hz:g}")
        return self

    def __call__(self, backend: Backend) -> Mapping[str, Value]:
        backend.set_rate(self.hz)
        return {}


@dataclass(frozen=True)
class LimitsCommand(Command, Action):
    window: Window

    @classmethod
    def read(cls, line: Line) -> "LimitsCommand":
        return cls(Window(line.real("force_min_N"), line.real("force_max_N"), line.real("travel_min_mm"),
                          line.real("travel_max_mm"), line.real("speed_max_mm_s")))

    def judge(self, s: Situation, token: int) -> Action:
        rules.check_limits(self.window, s)
        return self

    def __call__(self, backend: Backend) -> Mapping[str, Value]:
        backend.arm(self.window)
        return {}


@dataclass(frozen=True)
class ZeroCommand(Command, Action):
    force: bool
    travel: bool

    @classmethod
    def read(cls, line: Line) -> "ZeroCommand":
        return cls(line.flag("force"), line.flag("travel"))

    def judge(self, s: Situation, token: int) -> Action:
        can = s.capabilities
        require(self.force or self.travel, "bad_value", "neither force=1 nor travel=1")
        require(can.zero_force or not self.force, "unsupported", "this machine cannot zero its force")
        require(can.zero_travel or not self.travel, "unsupported", "this machine cannot zero its travel")
        require(not s.busy, "busy", s.busy)
        # Otherwise the zero would change under the force that the loop holds.
        require(not s.state.holds_force, "busy", "a force is being held: send HOLD mode=travel first")
        require(not (self.force and s.state.overload), "overload", "the load cell is beyond its range")
        require(s.state.force_N is not None or not self.force, "not_ready", "the force is not known")
        return self

    def __call__(self, backend: Backend) -> Mapping[str, Value]:
        backend.zero(self.force, self.travel)
        return {"origin": backend.origin()}


@dataclass(frozen=True)
class MoveCommand(Motion):
    travel_mm: float
    speed_mm_s: float

    def judge(self, s: Situation, token: int) -> Action:
        require(self.speed_mm_s > 0, "bad_value", "speed_mm_s of MOVE must be above 0")
        limits = rules.check_ready(s)
        rules.check_speed(self.speed_mm_s, s, limits)
        rules.check_travel("travel_mm", self.travel_mm, s, limits)
        direction = 1 if self.travel_mm > (s.state.travel_mm or 0.0) else -1
        watched = rules.window(direction, s, limits)
        return Start(Move(token, watched, self.travel_mm, self.speed_mm_s))


@dataclass(frozen=True)
class MoveToForceCommand(Motion):
    force_N: float
    speed_mm_s: float
    guard_mm: float

    def judge(self, s: Situation, token: int) -> Action:
        require(self.speed_mm_s != 0, "bad_value", "speed_mm_s of MOVEF must not be 0")
        limits = rules.check_ready(s)
        rules.check_speed(abs(self.speed_mm_s), s, limits)
        rules.check_force(self.force_N, limits)
        rules.check_travel("guard_mm", self.guard_mm, s, limits)
        watched = rules.window(1 if self.speed_mm_s > 0 else -1, s, limits)
        return Start(MoveToForce(token, watched, self.force_N, self.speed_mm_s, self.guard_mm))


def _loop_window(force_N: float, s: Situation, limits: Window) -> Window:
    """Force control may only go back from a contact that presses harder than wanted."""
    contact_N = s.capabilities.loop.force_contact_N if s.capabilities.loop else 0.0
    now_N = s.state.force_N
    require(now_N is not None, "overload", "the load cell is beyond its range: move to less travel first")
    assert now_N is not None
    back = now_N >= contact_N and force_N < now_N
    return rules.window(-1 if back else 1, s, limits)


@dataclass(frozen=True)
class RampForceCommand(Motion):
    force_N: float
    rate_N_s: float

    def judge(self, s: Situation, token: int) -> Action:
        require(self.rate_N_s > 0, "bad_value", "rate_N_s must be above 0")
        require(s.capabilities.force_hold, "unsupported", "this machine has no force loop")
        limits = rules.check_ready(s)
        loop = s.capabilities.loop
        if loop:
            require(self.rate_N_s <= loop.force_rate_max_N_s, "machine_limits",
                    f"faster than force_rate_max_N_s={loop.force_rate_max_N_s:g}")
        rules.check_force(self.force_N, limits)
        watched = _loop_window(self.force_N, s, limits)
        return Start(RampForce(token, watched, self.force_N, self.rate_N_s))


@dataclass(frozen=True)
class HoldTravelCommand(Command, Action):
    def judge(self, s: Situation, token: int) -> Action:
        return self

    def __call__(self, backend: Backend) -> Mapping[str, Value]:
        backend.stop()
        return {}


@dataclass(frozen=True)
class HoldForceCommand(Command):
    force_N: float
    moves = True

    def judge(self, s: Situation, token: int) -> Action:
        require(s.capabilities.force_hold, "unsupported", "this machine has no force loop")
        limits = rules.check_ready(s)
        rules.check_force(self.force_N, limits)
        watched = _loop_window(self.force_N, s, limits)
        require(_has_contact(s), "no_contact", "the force shows no contact: RAMPF approaches by itself")
        return _StartHold(HoldForce(watched, self.force_N))


@dataclass(frozen=True)
class _StartHold(Action):
    hold: HoldForce

    def __call__(self, backend: Backend) -> Mapping[str, Value]:
        backend.hold_force(self.hold)
        return {}


def _has_contact(s: Situation) -> bool:
    state: State = s.state
    loop = s.capabilities.loop
    return state.holds_force or (state.force_N is not None and loop is not None
                                 and state.force_N >= loop.force_contact_N)


def _read_hold(line: Line) -> Command:
    mode = line.text("mode")
    if mode == "travel":
        return HoldTravelCommand()
    if mode == "force":
        return HoldForceCommand.read(line)
    raise Refused("bad_value", "mode is travel or force")


_READERS = {
    "STATUS": StatusCommand.read,
    "RATE": RateCommand.read,
    "LIMITS": LimitsCommand.read,
    "ZERO": ZeroCommand.read,
    "MOVE": MoveCommand.read,
    "MOVEF": MoveToForceCommand.read,
    "RAMPF": RampForceCommand.read,
    "HOLD": _read_hold,
}


def read(line: Line) -> Command:
    """Raises Malformed (the line counts as not received), Missing or Refused."""
    if line.word not in _READERS:
        raise Refused("unknown_command", f"{line.word} is no command")
    return _READERS[line.word](line)
