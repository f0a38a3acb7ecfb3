# SPDX-License-Identifier: Apache-2.0
"""What the author of a gateway implements for a machine: one class, `Backend`.

Signs and units are those of the link: N and mm, compression positive, travel grows towards the
specimen. Forces and travels are values as the machine shows them, after tare.

Threads: the link thread makes the calls marked AT ONCE. They must return within a few milliseconds,
whatever the machine or another call does, because `stop` is called in the same thread. The command
thread makes the calls marked MAY BLOCK, one at a time. The answer to the daemon waits for them, so
0.5 s is the most they should take (section 4 allows 1 s in all). A back end may call its `Listener`
from any thread; these calls never block.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass
from typing import Protocol, Sequence, Union


class Refused(Exception):
    """A command that the machine does not accept. `code` is one of the errors of section 4."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code
        self.text = text


@dataclass(frozen=True)
class Identity:
    maker: str
    model: str
    serial: str
    version: str
    simulated: bool = False


@dataclass(frozen=True)
class ForceLoop:
    """Second table of CAPS: what the closed force loop does in the worst case."""

    force_approach_mm_s: float
    force_contact_N: float
    force_rate_max_N_s: float
    force_lag_s: float
    force_ripple_N: float
    force_stiffness_max_N_mm: float


@dataclass(frozen=True)
class Capabilities:
    """The tables of CAPS, with the same names. Each value is a bound that holds in the worst case.

    Travel is as the machine shows it at present. After a zero of travel the numbers differ, but the
    places are the same.
    """

    motion: bool
    device_stop: bool
    force_hold: bool
    force: bool
    travel: bool
    zero_force: bool
    zero_travel: bool
    force_max_N: float
    speed_min_mm_s: float
    speed_max_mm_s: float
    travel_min_mm: float
    travel_max_mm: float
    rate_max_hz: float
    reaction_s: float
    deceleration_mm_s2: float
    loop: ForceLoop | None = None  # with force_hold
    # Third table: what the samples show, and what the drive does. None is not sent; the daemon's
    # config has to state it then.
    force_class: float | None = None
    travel_step_um: float | None = None
    force_step_mN: float | None = None
    filter_s: float | None = None
    play_um: float | None = None

    def fields(self, revision: int) -> dict[str, bool | float | None]:
        fields = asdict(self)
        loop = fields.pop("loop")
        if revision < 3:
            for key in STATED:
                del fields[key]
        return {**fields, **loop} if loop and revision >= 2 else fields


STATED = ("force_class", "travel_step_um", "force_step_mN", "filter_s", "play_um")


@dataclass(frozen=True)
class State:
    """The machine's own account of what it is doing."""

    moving: bool  # until it is known to stand; a hold that has reached its force does not count
    holds_force: bool  # force control is on
    force_N: float | None  # None: not known, or beyond the load cell
    travel_mm: float | None
    overload: bool  # force beyond the load cell
    force_noise_N: float  # largest deviation of the force shown by a machine at rest
    not_ready: str = ""  # why it cannot move: drive off, E-stop, shield open; empty: it can
    device_s: float | None = None  # the device's own clock, if it has one


@dataclass(frozen=True)
class Window:
    """What the device watches during one motion: the daemon's LIMITS, widened for the way back."""

    force_min_N: float
    force_max_N: float
    travel_min_mm: float
    travel_max_mm: float
    speed_max_mm_s: float


@dataclass(frozen=True)
class Move:
    token: int  # given back in Ended
    window: Window
    travel_mm: float
    speed_mm_s: float


@dataclass(frozen=True)
class MoveToForce:
    """Ends with `target` when the force is at least (speed > 0) or at most (speed < 0) force_N, or
    with `travel_limit` at guard_mm, beyond which it must not go. Both may be true at the
    beginning."""

    token: int
    window: Window
    force_N: float
    speed_mm_s: float
    guard_mm: float


@dataclass(frozen=True)
class RampForce:
    """Approaches if there is no contact, ramps, ends with `target` and then holds the force."""

    token: int
    window: Window
    force_N: float
    rate_N_s: float


Motion = Union[Move, MoveToForce, RampForce]


@dataclass(frozen=True)
class HoldForce:
    window: Window
    force_N: float


@dataclass(frozen=True)
class Sample:
    t_s: float | None  # the device's own clock
    force_N: float | None
    travel_mm: float | None
    moving: bool = False
    force_control: bool = False
    overload: bool = False
    flags_known: bool = True
    lost_before: int = 0  # how many samples the machine took and lost just before this one


@dataclass(frozen=True)
class Ended:
    """A motion has ended. The machine stands, or has begun to hold the force of a RAMPF."""

    token: int
    reason: str  # target, force_limit, travel_limit, stop, fault
    text: str = ""
    force_N: float | None = None
    travel_mm: float | None = None


class Listener(Protocol):
    """What a back end reports to the gateway. Samples and ends are passed on in this order."""

    def samples(self, samples: Sequence[Sample]) -> None: ...

    def ended(self, end: Ended) -> None: ...

    def event(self, kind: str, text: str) -> None: ...

    def origin_changed(self, origin: str, text: str) -> None:
        """A zero changed, but not by zero(): a tare at the panel, a new reference run."""


class Backend(ABC):
    """One machine. See docs/gateway.md."""

    # --- AT ONCE, from any thread, in every state ---

    @abstractmethod
    def stop(self) -> None:
        """Begin to decelerate within 20 ms, end force control and hold the travel.

        Must not wait for standstill, a lock, a file or another call of this class. A start() that
        is under way in the command thread must either refuse or be stopped too. After stop() was
        called, state() must not report standstill before the stop was carried out.
        """

    @abstractmethod
    def state(self) -> State: ...

    @abstractmethod
    def identity(self) -> Identity: ...

    @abstractmethod
    def capabilities(self) -> Capabilities: ...

    @abstractmethod
    def origin(self) -> str:
        """Changes whenever the zero of force or travel may have changed. A value never comes again,
        not even after a restart that lost the zero."""

    # --- MAY BLOCK, in the command thread, one at a time. Each may raise Refused. ---

    def refresh(self) -> None:
        """Called before each command is judged. A slow query of the machine belongs here."""

    def arm(self, window: Window) -> None:
        """LIMITS were accepted. If the machine can take limits of its own, give it these, and
        return when it has them. They also apply to a force that is being held."""

    @abstractmethod
    def start(self, motion: Motion) -> None:
        """Begin a motion and return. Listener.ended() reports its end exactly once."""

    def hold_force(self, hold: HoldForce) -> None:
        raise Refused("unsupported", "this machine has no force loop")

    def zero(self, force: bool, travel: bool) -> None:
        """Make the present values 0 and change origin()."""
        raise Refused("unsupported", "this machine sets no zero")

    @abstractmethod
    def set_rate(self, hz: float) -> None:
        """Set the samples per second for Listener.samples(); 0 means none. After set_rate(0) has
        returned, no sample taken before it may be passed on."""

    # --- life of the gateway ---

    @abstractmethod
    def open(self, listener: Listener) -> None:
        """Called once, before anything else but identity()."""

    @abstractmethod
    def close(self) -> None:
        """Called once at the end, after the motions commanded by a daemon were told to stop."""
