# SPDX-License-Identifier: Apache-2.0
"""The hooks of a machine that lies or breaks. An honest machine passes every value on. A lie
(cell_lies.py, drive_lies.py) overrides some of the hooks, and does so only from its beginning to
its end."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Callable, ClassVar, Iterable, Mapping, Protocol, Sequence

from ..backend import Capabilities


class Victim(Protocol):
    """What a lie can do to the machine when it begins or ends."""

    def trip(self, kind: str, text: str) -> None:
        """The drive is cut off. A motion under way ends with a fault, and an EVENT reports it."""

    def forget_tare(self, told: bool) -> None:
        """told: the machine notices it and reports a new origin."""

    def restart_link(self) -> None:
        """The gateway hangs up, as if it had restarted."""

    def note_lie(self, name: str, on: bool) -> None: ...


class Honest:
    # --- load cell ---

    def felt_N(self, t_s: float, force_N: float) -> float:
        """The force as the load cell senses it."""
        return force_N

    def scatter_N(self, noise_N: float) -> float:
        """Standard deviation of a reading."""
        return noise_N

    def read_N(self, raw_N: float) -> float:
        """The reading with noise, before tare."""
        return raw_N

    # --- drive ---

    def driven_mm_s(self, speed_mm_s: float) -> float:
        """The speed of the crosshead at this speed of the drive."""
        return speed_mm_s

    def not_ready(self) -> str:
        """Why the machine cannot move; empty if it can."""
        return ""

    def stopped(self) -> None:
        """Called when the drive carries out a STOP."""

    # --- orders and ends ---

    def order_delay_s(self) -> float:
        """An accepted motion begins this much later."""
        return 0.0

    def stop_delay_s(self) -> float:
        """A STOP is carried out this much later; inf: never."""
        return 0.0

    def false_done_s(self) -> float | None:
        """If not None, this motion does not take place, and DONE says target after this time."""
        return None

    def claims_target(self) -> bool:
        """Such a DONE contains the requested values, not the present ones."""
        return False

    def ends_early(self, age_s: float) -> bool:
        """DONE of a motion of this age is sent now, while it goes on."""
        return False

    def hides_motion(self) -> bool:
        """After such a DONE the machine says that it stands."""
        return False

    def done_delay_s(self) -> float:
        """DONE is sent this long after standstill."""
        return 0.0

    def done_told(self) -> None:
        """Called when a motion has ended and DONE is sent."""

    # --- samples, clock, what is declared, the link ---

    def clock_s(self, device_s: float) -> float:
        """The time that the device's clock shows."""
        return device_s

    def sample_due_s(self, t_s: float) -> float:
        """When a sample taken at t_s is handed over."""
        return t_s

    def done_overtakes_samples(self) -> bool:
        return False

    def declares(self, true: Capabilities) -> Capabilities:
        return true

    def withholds(self, line: bytes) -> bool:
        """True for a line to the daemon that is not sent. Called by the link thread."""
        return False

    # --- time ---

    def follow(self, t_s: float, motion: int, since_s: float, victim: Victim) -> None:
        """Called with the time, the number of motions accepted so far, and the time since the last
        one."""

    def untold(self) -> Sequence[str]:
        """Lies that have not begun yet."""
        return ()


@dataclass(frozen=True)
class When:
    """From at_s on, or from after_s of the n-th motion on. It lasts for_s, or for ever."""

    at_s: float = 0.0
    motion: int = 0  # 0: at_s counts
    after_s: float = 0.0
    for_s: float = math.inf

    def due(self, t_s: float, motion: int, since_s: float) -> bool:
        if not self.motion:
            return t_s >= self.at_s
        return motion > self.motion or motion == self.motion and since_s >= self.after_s


@dataclass(frozen=True)
class Parameter:
    meaning: str
    default: float | None = None  # None: must be given unless it is optional
    low: float = -math.inf
    high: float = math.inf
    optional: bool = False


class Lie(Honest):
    """One lie. `on` says whether it is being told."""

    name: ClassVar[str]
    meaning: ClassVar[str]
    parameters: ClassVar[Mapping[str, Parameter]] = {}

    def __init__(self, when: When, values: Mapping[str, float], times: float = math.inf) -> None:
        self._when = when
        self._value = values
        self._left = times  # how many motions it still applies to
        self._began = False
        self.on = False
        self.t_s = self.began_s = 0.0

    def follow(self, t_s: float, motion: int, since_s: float, victim: Victim) -> None:
        self.t_s = t_s
        if not self._began and self._when.due(t_s, motion, since_s):
            self._began, self.on, self.began_s = True, True, t_s
            victim.note_lie(self.name, True)
            self.begin(victim)
        if self.on and t_s >= self.began_s + self._when.for_s:
            self.on = False
            victim.note_lie(self.name, False)

    def begin(self, victim: Victim) -> None:
        """Called once, when the lie begins."""

    def untold(self) -> Sequence[str]:
        return () if self._began else (self.name,)

    def once_more(self) -> bool:
        """Counts one motion."""
        self._left -= 1
        return self._left >= 0


class CountedLie(Lie):
    """A lie about single motions, which takes `times`."""


class Lies(Honest):
    """Several lies at once. Each is applied to the result of the one before."""

    def __init__(self, lies: Iterable[Lie] = ()) -> None:
        self._lies = list(lies)

    def add(self, lie: Lie) -> None:
        self._lies.append(lie)

    def _told(self) -> Sequence[Lie]:
        return [lie for lie in self._lies if lie.on]

    def _through(self, value: Any, hook: Callable[[Lie, Any], Any]) -> Any:
        for lie in self._lies:
            if lie.on:
                value = hook(lie, value)
        return value

    def felt_N(self, t_s: float, force_N: float) -> float:
        return float(self._through(force_N, lambda lie, x: lie.felt_N(t_s, x)))

    def scatter_N(self, noise_N: float) -> float:
        return float(self._through(noise_N, lambda lie, x: lie.scatter_N(x)))

    def read_N(self, raw_N: float) -> float:
        return float(self._through(raw_N, lambda lie, x: lie.read_N(x)))

    def driven_mm_s(self, speed_mm_s: float) -> float:
        return float(self._through(speed_mm_s, lambda lie, x: lie.driven_mm_s(x)))

    def not_ready(self) -> str:
        return next(filter(None, (lie.not_ready() for lie in self._told())), "")

    def stopped(self) -> None:
        for lie in self._lies:
            lie.stopped()

    def order_delay_s(self) -> float:
        return sum(lie.order_delay_s() for lie in self._told())

    def stop_delay_s(self) -> float:
        return sum(lie.stop_delay_s() for lie in self._told())

    def false_done_s(self) -> float | None:
        delays_s = [lie.false_done_s() for lie in self._told()]
        return next((delay_s for delay_s in delays_s if delay_s is not None), None)

    def claims_target(self) -> bool:
        return any(lie.claims_target() for lie in self._told())

    def ends_early(self, age_s: float) -> bool:
        return any([lie.ends_early(age_s) for lie in self._told()])

    def hides_motion(self) -> bool:
        return any(lie.hides_motion() for lie in self._told())

    def done_delay_s(self) -> float:
        return sum(lie.done_delay_s() for lie in self._told())

    def done_told(self) -> None:
        for lie in self._lies:
            lie.done_told()

    def clock_s(self, device_s: float) -> float:
        return float(self._through(device_s, lambda lie, x: lie.clock_s(x)))

    def sample_due_s(self, t_s: float) -> float:
        return float(self._through(t_s, lambda lie, x: lie.sample_due_s(x)))

    def done_overtakes_samples(self) -> bool:
        return any(lie.done_overtakes_samples() for lie in self._told())

    def declares(self, true: Capabilities) -> Capabilities:
        said: Capabilities = self._through(true, lambda lie, x: lie.declares(x))
        return said

    def withholds(self, line: bytes) -> bool:
        return any(lie.withholds(line) for lie in self._told())

    def follow(self, t_s: float, motion: int, since_s: float, victim: Victim) -> None:
        for lie in self._lies:
            lie.follow(t_s, motion, since_s, victim)

    def untold(self) -> Sequence[str]:
        return [name for lie in self._lies for name in lie.untold()]
