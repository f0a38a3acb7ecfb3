# SPDX-License-Identifier: Apache-2.0
"""Lies of the drive, of the ends of motions, of STOP, and of the machine's declarations."""

from __future__ import annotations

import math
from dataclasses import replace

from ..backend import Capabilities
from .lies import CountedLie, Lie, Parameter, Victim


class DriveStalled(Lie):
    name = "drive_stalled"
    meaning = "the drive turns and the axis stays where it is"

    def driven_mm_s(self, speed_mm_s: float) -> float:
        return 0.0


class DriveReversed(Lie):
    name = "drive_reversed"
    meaning = "the axis goes the other way"

    def driven_mm_s(self, speed_mm_s: float) -> float:
        return -speed_mm_s


class Creep(Lie):
    name = "creep"
    meaning = "after a DONE the axis creeps on, and says that it stands"
    parameters = {"speed_um_s": Parameter("so fast; negative: away from the specimen"),
                  "stop_ends": Parameter("1: a STOP (or HOLD) ends it until the next DONE", 0, 0, 1)}
    _creeps = False

    def done_told(self) -> None:
        self._creeps = True

    def stopped(self) -> None:
        self._creeps = self._creeps and not self._value["stop_ends"]

    def driven_mm_s(self, speed_mm_s: float) -> float:
        return self._value["speed_um_s"] * 1e-3 if self._creeps and not speed_mm_s else speed_mm_s


class DoneEarly(CountedLie):
    name = "done_early"
    meaning = "DONE says target while the axis goes on"
    parameters = {"delay_s": Parameter("so long after the motion was begun", 0.1, 0),
                  "shown": Parameter("1: the flags of the samples still say that it moves", 0, 0, 1)}

    def ends_early(self, age_s: float) -> bool:
        return age_s >= self._value["delay_s"] and self.once_more()

    def hides_motion(self) -> bool:
        return not self._value["shown"]


class DoneUnmoved(CountedLie):
    name = "done_unmoved"
    meaning = "a motion does not take place, and DONE says target"
    parameters = {"delay_s": Parameter("so long after its begin", 0.5, 0),
                  "claims": Parameter("0: DONE has the force and travel that are there, "
                                      "not those that were asked for", 1, 0, 1)}

    def false_done_s(self) -> float | None:
        return self._value["delay_s"] if self.once_more() else None

    def claims_target(self) -> bool:
        return bool(self._value["claims"])


class DoneLate(CountedLie):
    name = "done_late"
    meaning = "DONE comes later than standstill"
    parameters = {"delay_s": Parameter("so much", low=0)}

    def done_delay_s(self) -> float:
        return self._value["delay_s"] if self.once_more() else 0.0


class OrderLate(CountedLie):
    name = "order_late"
    meaning = "a motion is accepted at once and carried out later, also after a STOP"
    parameters = {"delay_s": Parameter("so much", low=0)}

    def order_delay_s(self) -> float:
        return self._value["delay_s"] if self.once_more() else 0.0


class Estop(Lie):
    name = "estop"
    meaning = "E-stop: EVENT, DONE fault, no motion until it is released (for_s; a pulse: for_s=0.05)"

    def begin(self, victim: Victim) -> None:
        victim.trip("estop", "E-stop")

    def not_ready(self) -> str:
        return "E-stop"


class StopLate(Lie):
    name = "stop_late"
    meaning = "STOP, silence and the end of the connection act later"
    parameters = {"delay_s": Parameter("so much", low=0)}

    def stop_delay_s(self) -> float:
        return self._value["delay_s"]


class StopUnconfirmed(Lie):
    name = "stop_unconfirmed"
    meaning = "STOP is obeyed, and STOPPED never comes"

    def withholds(self, line: bytes) -> bool:
        return line.startswith(b"STOPPED")


class StopIgnored(Lie):
    name = "stop_ignored"
    meaning = "the axis goes on, whatever says stop"

    def stop_delay_s(self) -> float:
        return math.inf


class CapsChanged(Lie):
    name = "caps_changed"
    meaning = "the gateway hangs up and comes back with other CAPS; without a value: half the speed"
    parameters = {key: Parameter(f"{key} of CAPS", low=1e-9, optional=True)
                  for key in ("force_max_N", "speed_max_mm_s", "reaction_s", "deceleration_mm_s2")}

    def begin(self, victim: Victim) -> None:
        victim.restart_link()

    def declares(self, true: Capabilities) -> Capabilities:
        changed = dict(self._value) or {"speed_max_mm_s": true.speed_max_mm_s / 2}
        return replace(true, **changed)


ALL = (DriveStalled, DriveReversed, Creep, DoneEarly, DoneUnmoved, DoneLate, OrderLate, Estop, StopLate,
       StopUnconfirmed, StopIgnored, CapsChanged)
