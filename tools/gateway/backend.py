# SPDX-License-Identifier: Apache-2.0
"""What the author of a gateway implements for his machine: one class, `Backend`.

Signs and units are those of the link: N and mm, compression positive, travel grows towards the
specimen. Forces and travels are values as the machine shows them, after tare.

Threads. The link thread calls what is marked AT ONCE: it must return within a few milliseconds,
whatever the machine or another call does, because `stop` goes the same way. The command thread calls
what is marked MAY BLOCK, one call at a time; the answer to the daemon waits for it, so 0.5 s is the
most that is decent (section 4 allows 1 s in all). A back end may call its `Listener` from any thread;
those calls never block.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass
from typing import Protocol, Sequence, Union


class Refused(Exception):
    """A command that the machine does not take. `code` is one of section 4's table of errors."""

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
    """First table of CAPS, by the same names. Each value is a bound that holds in the worst case.

    Travel is as the machine shows it at present: after a zero of travel the numbers are others, the
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

    def fields(self, revision: int) -> dict[str, bool | float]:
        fields = asdict(self)
        loop = fields.pop("loop")
        return {**fields, **loop} if loop and revision >= 2 else fields


@dataclass(frozen=True)
class State:
    """What the machine does at present, by its own account."""

    moving: bool  # until it verifiably stands; a hold that has reached its force does not count
    holds_force: bool  # force control is on
    force_N: float | None  # None: not known, or beyond the load cell
    travel_mm: float | None
    overload: bool  # force beyond the load cell
    force_noise_N: float  # how far the shown force of a machine at rest strays, at most
    not_ready: str = ""  # why it cannot move: drive off, E-stop, shield open; empty: it can
    device_s: float | None = None  # the device's own clock, if it has one


@dataclass(frozen=True)
class Window:
    """What the device watches during one motion. The daemon's LIMITS, widened for the way back."""

    force_min_N: float
    force_max_N: float
    travel_min_mm: float
    travel_max_mm: float
    speed_max_mm_s: float


@dataclass(frozen=True)
class Move:
    token: int  # comes back in Ended
    window: Window
    travel_mm: float
    speed_mm_s: float


@dataclass(frozen=True)
class MoveToForce:
    """Ends with `target` when the force is at least (speed > 0) or at most (speed < 0) force_N, with
    `travel_limit` at guard_mm, where it stands at the latest. Both may be so at the beginning."""

    token: int
    window: Window
    force_N: float
    speed_mm_s: float
    guard_mm: float


@dataclass(frozen=True)
class RampForce:
    """Approaches if there is no contact, ramps, ends with `target` and goes on holding the force."""

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
    lost_before: int = 0  # samples that the machine took and lost just before this one


@dataclass(frozen=True)
class Ended:
    """A motion ended and the machine stands, or has begun to hold the force of a RAMPF."""

    token: int
    reason: str  # target, force_limit, travel_limit, stop, fault
    text: str = ""
    force_N: float | None = None
    travel_mm: float | None = None


class Listener(Protocol):
    """What a back end tells the gateway. Samples and ends are passed on in this order."""

    def samples(self, samples: Sequence[Sample]) -> None: ...

    def ended(self, end: Ended) -> None: ...

    def event(self, kind: str, text: str) -> None: ...

    def origin_changed(self, origin: str, text: str) -> None:
        """A zero changed, and not by zero(): a tare at the panel, a new reference run."""


class Backend(ABC):
    """One machine. See docs/gateway.md."""

    # --- AT ONCE, from any thread, in every state ---

    @abstractmethod
    def stop(self) -> None:
        """Begin to decelerate within 20 ms, end force control, hold the travel.

        Must not wait for standstill, a lock, a file or another call of this class. A start() that is
        under way in the command thread either refuses or is stopped too. Once stop() was called,
        state() does not say standing before the stop was carried out.
        """

    @abstractmethod
    def state(self) -> State: ...

    @abstractmethod
    def identity(self) -> Identity: ...

    @abstractmethod
    def capabilities(self) -> Capabilities: ...

    @abstractmethod
    def origin(self) -> str:
        """Changes whenever the zero of force or travel may have changed; never the same again, also
        not after a restart that forgot the zero."""

    # --- MAY BLOCK, in the command thread, one at a time. Each may raise Refused. ---

    def refresh(self) -> None:
        """Called before each command is judged: the place for a slow look at the machine."""

    def arm(self, window: Window) -> None:
        """LIMITS were accepted. A machine that can take limits of its own takes these, and returns
        when it has. They also hold for a force that is being held."""

    @abstractmethod
    def start(self, motion: Motion) -> None:
        """Begin a motion and return; Listener.ended() tells its end, exactly once."""

    def hold_force(self, hold: HoldForce) -> None:
        raise Refused("unsupported", "this machine has no force loop")

    def zero(self, force: bool, travel: bool) -> None:
        """The present values become 0, and origin() is another one."""
        raise Refused("unsupported", "this machine sets no zero")

    @abstractmethod
    def set_rate(self, hz: float) -> None:
        """Samples per second to Listener.samples(), 0: none. Once set_rate(0) has returned, none that
        was taken before it is passed on."""

    # --- life of the gateway ---

    @abstractmethod
    def open(self, listener: Listener) -> None:
        """Called once, before anything else but identity()."""

    @abstractmethod
    def close(self) -> None:
        """Called once at the end. What a daemon commanded has been told to stop by then."""
