# SPDX-License-Identifier: Apache-2.0
"""The closed force loop of the simulated device: in every cycle it sets a speed from the force
read."""

from __future__ import annotations

import math
from collections import deque

from .rig import STEP_S, Rig

_SETTLED_S = 0.02


class ForceLoop:
    """Follows a reference that goes to the target at a rate. Like an adaptive controller it knows
    the slope of the force, but it acts on readings that are loop_delay_s old. That is why it
    overshoots."""

    def __init__(self, rig: Rig, now_N: float, target_N: float, rate_N_s: float,
                 tolerance_N: float) -> None:
        self._rig = rig
        self._cycle_s = max(1, round(rig.device_cycle_s / STEP_S)) * STEP_S
        self._readings = deque([now_N], maxlen=max(1, round(rig.loop_delay_s / self._cycle_s)) + 1)
        self._reference_N = now_N
        self._rate_N_s = rate_N_s
        self._tolerance_N = tolerance_N
        self._within_s = 0.0
        self.target_N = target_N
        self.settled = False  # the target was reached and is now held
        self.speed_mm_s = 0.0

    def cycle(self, t_s: float, reading_N: float, stiffness_N_mm: float) -> None:
        self._readings.append(reading_N)
        slope_N_s = self._advance_reference()
        error_N = self._reference_N - self._readings[0]
        wanted_N_s = slope_N_s + error_N / self._rig.loop_response_s + self._ripple_N_s(t_s)
        stiffness = min(stiffness_N_mm, self._rig.loop_stiffness_max_N_mm)
        fastest = self._rig.loop_speed_mm_s
        self.speed_mm_s = max(-fastest, min(fastest, wanted_N_s / stiffness))
        self._see_whether_settled(reading_N)

    def _advance_reference(self) -> float:
        """Returns the slope of the reference. The reference waits for a force that cannot follow,
        so that the force does not overshoot later."""
        step_N = self._rate_N_s * self._cycle_s
        ahead_N = self._rate_N_s * 2 * self._rig.loop_response_s
        to_go_N = self.target_N - self._reference_N
        if abs(to_go_N) <= step_N:
            self._reference_N = self.target_N
            return 0.0
        slope_N_s = math.copysign(self._rate_N_s, to_go_N)
        measured_N = self._readings[0]
        if abs(self._reference_N - measured_N) < ahead_N or slope_N_s * (self._reference_N - measured_N) < 0:
            self._reference_N += slope_N_s * self._cycle_s
        return slope_N_s

    def _ripple_N_s(self, t_s: float) -> float:
        omega = 2 * math.pi * self._rig.loop_ripple_hz
        return self._rig.loop_ripple_N * omega * math.cos(omega * t_s)

    def _see_whether_settled(self, reading_N: float) -> None:
        there = (self._reference_N == self.target_N
                 and abs(reading_N - self.target_N) <= self._tolerance_N)
        self._within_s = self._within_s + self._cycle_s if there else 0.0
        self.settled = self.settled or self._within_s >= _SETTLED_S
