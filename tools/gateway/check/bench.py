# SPDX-License-Identifier: Apache-2.0
"""What the checks share: the gateway, the user's permissions, and the list of checks."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Callable, Mapping

from ..protocol import Line
from .client import Client, Failed, Received, Skipped

HELLO = "HELLO proto=1 revision=3 side=host maker=lcrig model=check version=0"
OBSERVE = "OBSERVE proto=1 revision=3 side=host maker=lcrig model=check version=0"
CAPS_FLAGS = ("motion", "device_stop", "force_hold", "force", "travel", "zero_force", "zero_travel")
CAPS_NUMBERS = ("force_max_N", "speed_min_mm_s", "speed_max_mm_s", "travel_min_mm", "travel_max_mm",
                "rate_max_hz", "reaction_s", "deceleration_mm_s2")
LOOP_NUMBERS = ("force_approach_mm_s", "force_contact_N", "force_rate_max_N_s", "force_lag_s",
                "force_ripple_N", "force_stiffness_max_N_mm")
# Revision 3, by the flag of CAPS with which they are required.
STATED_NUMBERS = {"force": ("force_step_mN", "filter_s"), "travel": ("travel_step_um",),
                  "motion": ("play_um",)}
NOT_NEGATIVE = ("force_lag_s", "force_ripple_N", "travel_step_um", "force_step_mN", "filter_s", "play_um")
FORCE_CLASSES = (0.5, 1.0, 2.0, 3.0)


@dataclass
class Bench:
    host: str
    port: int
    patience: float = 1.0  # factor on all times that a slow computer may exceed
    move: bool = False
    zero: bool = False
    travel_mm: tuple[float, float] = (0.0, 0.0)
    force_max_N: float = 0.0
    speed_mm_s: float = 1.0
    panel: tuple[str, int] | None = None
    say: Callable[[str], None] = print
    ill_formed: list[str] = field(default_factory=list)
    hello: Mapping[str, str] = field(default_factory=dict)
    caps: Mapping[str, str] = field(default_factory=dict)

    @property
    def revision(self) -> int:
        return int(self.hello.get("revision", "1"))

    def cap(self, key: str) -> float:
        return Line("CAPS", None, self.caps).real(key)

    def need_revision_2(self) -> None:
        if self.revision < 2:
            raise Skipped("the gateway has revision 1")

    def rate_hz(self) -> float:
        return min(50.0, self.cap("rate_max_hz"))

    def connect(self) -> Client:
        return Client(self.host, self.port, self.patience, self.ill_formed)

    def open(self, client: Client, word: str = HELLO) -> tuple[Received, Received]:
        """HELLO or OBSERVE, up to CAPS."""
        mark = client.mark()
        client.begin_numbers()
        client.send(word)
        hello = client.expect("HELLO", mark, lambda r: r.word == "HELLO", 1.0 * self.patience)
        caps = client.expect("CAPS", mark, lambda r: r.word == "CAPS", 1.0 * self.patience)
        return hello, caps

    def session(self, hz: float = 0.0) -> Client:
        """A connection with a session that may command."""
        client = self.connect()
        try:
            self.open(client)
            if hz:
                client.accepted(f"RATE hz={hz:g}")
        except BaseException:
            client.close()
            raise
        return client

    def last_sample(self, client: Client, mark: int = 0) -> Received:
        """The first sample since the mark that has a travel."""
        return client.expect("a sample with travel_mm", mark,
                             lambda r: r.word == "S" and bool(travels_mm(r)), 2.0 * self.patience)

    def present_travel_mm(self, client: Client) -> float:
        return travels_mm(self.last_sample(client, client.mark()))[-1]

    def arm(self, client: Client, force_max_N: float | None = None) -> None:
        low, high = self.travel_mm
        most = self.force_max_N if force_max_N is None else force_max_N
        client.accepted(f"LIMITS force_min_N={-self.force_max_N:g} force_max_N={most:g} "
                        f"travel_min_mm={low:g} travel_max_mm={high:g} "
                        f"speed_max_mm_s={self.fastest_mm_s():g}")

    def widest_limits(self, **changes: float) -> str:
        """LIMITS slightly inside of what CAPS say."""
        low, high = self.cap("travel_min_mm"), self.cap("travel_max_mm")
        inset_mm = 0.01 * (high - low)
        limits = {"force_min_N": -0.99 * self.cap("force_max_N"),
                  "force_max_N": 0.99 * self.cap("force_max_N"), "travel_min_mm": low + inset_mm,
                  "travel_max_mm": high - inset_mm,
                  "speed_max_mm_s": 0.99 * self.cap("speed_max_mm_s"), **changes}
        return "LIMITS " + " ".join(f"{key}={value:f}" for key, value in limits.items())

    def fastest_mm_s(self) -> float:
        return min(2 * self.speed_mm_s, self.cap("speed_max_mm_s"))


def values(samples: Received, key: str) -> list[float | None]:
    count = int(samples.line.fields["n"])
    if key not in samples.line.fields:
        return [None] * count
    return [float(v) if v else None for v in samples.line.fields[key].split(",")]


def travels_mm(samples: Received) -> list[float]:
    """All travels, without missing values."""
    return [v for v in values(samples, "travel_mm") if v is not None]


def flags(samples: Received) -> list[str]:
    words = samples.line.fields.get("flags", "").split(",")
    return words * int(samples.line.fields["n"]) if len(words) == 1 else words


@dataclass(frozen=True)
class Check:
    name: str
    section: str
    promise: str
    run: Callable[[Bench], None]
    moves: bool


CHECKS: list[Check] = []


def check(name: str, section: str, promise: str,
          moves: bool = False) -> Callable[[Callable[[Bench], None]], Callable[[Bench], None]]:
    """Decorator that adds a function to the list of checks. The promise is kept unless the function
    raises Failed or Skipped."""

    def add(run: Callable[[Bench], None]) -> Callable[[Bench], None]:
        CHECKS.append(Check(name, section, promise, run, moves))
        return run

    return add


def require(condition: bool, text: str) -> None:
    if not condition:
        raise Failed(text)


def now_s() -> float:
    return time.monotonic()
