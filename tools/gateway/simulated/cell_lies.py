# SPDX-License-Identifier: Apache-2.0
"""Lies of the load cell, its tare, the samples and their clock."""

from __future__ import annotations

import math

from .lies import Lie, Parameter, Victim


class ForceFrozen(Lie):
    name = "force_frozen"
    meaning = "the force stays at its last reading, to the last digit"
    _kept_N: float | None = None

    def read_N(self, raw_N: float) -> float:
        if self._kept_N is None:
            self._kept_N = raw_N
        return self._kept_N


class ForceHeld(Lie):
    name = "force_held"
    meaning = "the force stays at its mean, and scatters on"
    _kept_N: float | None = None

    def felt_N(self, t_s: float, force_N: float) -> float:
        if self._kept_N is None:
            self._kept_N = force_N
        return self._kept_N


class ForceGain(Lie):
    name = "force_gain"
    meaning = "the load cell shows a part of the force, or more of it"
    parameters = {"factor": Parameter("so many times", low=0)}

    def felt_N(self, t_s: float, force_N: float) -> float:
        return force_N * self._value["factor"]


class ForceReversed(Lie):
    name = "force_reversed"
    meaning = "the load cell shows compression as tension"

    def felt_N(self, t_s: float, force_N: float) -> float:
        return -force_N


class ForceDrift(Lie):
    name = "force_drift"
    meaning = "the force shown runs away"
    parameters = {"rate_N_s": Parameter("so fast")}

    def felt_N(self, t_s: float, force_N: float) -> float:
        return force_N + self._value["rate_N_s"] * (t_s - self.began_s)


class ForceScatter(Lie):
    name = "force_scatter"
    meaning = "the noise of the load cell grows"
    parameters = {"factor": Parameter("so many times", low=0)}

    def scatter_N(self, noise_N: float) -> float:
        return noise_N * self._value["factor"]


class TareLost(Lie):
    name = "tare_lost"
    meaning = "the tare of the force is forgotten (give the cell a cell_offset_N)"
    parameters = {"origin_changes": Parameter("1: a new origin is said", 0, 0, 1),
                  "restart": Parameter("1: the gateway hangs up at the same time", 0, 0, 1)}

    def begin(self, victim: Victim) -> None:
        victim.forget_tare(bool(self._value["origin_changes"]))
        if self._value["restart"]:
            victim.restart_link()


class ClockFrozen(Lie):
    name = "clock_frozen"
    meaning = "t_s stands still"
    _kept_s: float | None = None

    def clock_s(self, device_s: float) -> float:
        if self._kept_s is None:
            # the first question after the lie began
            self._kept_s = device_s - (self.t_s - self.began_s)
        return self._kept_s


class ClockJump(Lie):
    name = "clock_jump"
    meaning = "t_s jumps, and jumps back after for_s"
    parameters = {"jump_s": Parameter("so far; negative: back")}

    def clock_s(self, device_s: float) -> float:
        return device_s + self._value["jump_s"]


class ClockRate(Lie):
    name = "clock_rate"
    meaning = "t_s runs at another rate"
    parameters = {"factor": Parameter("so many times as fast", low=0)}

    def clock_s(self, device_s: float) -> float:
        return device_s + (self._value["factor"] - 1) * (self.t_s - self.began_s)


class SamplesLate(Lie):
    name = "samples_late"
    meaning = "samples come later; DONE and STOPPED do not wait for them"
    parameters = {"delay_s": Parameter("so much", low=0, high=60)}

    def sample_due_s(self, t_s: float) -> float:
        return t_s + self._value["delay_s"]

    def done_overtakes_samples(self) -> bool:
        return True


class SamplesBurst(Lie):
    name = "samples_burst"
    meaning = "samples come all at once, now and then"
    parameters = {"period_s": Parameter("so often", low=0.001, high=60)}

    def sample_due_s(self, t_s: float) -> float:
        period_s = self._value["period_s"]
        return math.ceil(t_s / period_s) * period_s


ALL = (ForceFrozen, ForceHeld, ForceGain, ForceReversed, ForceDrift, ForceScatter, TareLost, ClockFrozen,
       ClockJump, ClockRate, SamplesLate, SamplesBurst)
