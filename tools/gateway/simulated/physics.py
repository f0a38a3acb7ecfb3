# SPDX-License-Identifier: Apache-2.0
"""Drive, specimen and load cell. Travel is in the machine's own coordinates. Time goes in steps of
STEP_S."""

from __future__ import annotations

import math
import random

from .lies import Honest
from .rig import STEP_S, Rig


class Specimen:
    """Everything that gives way in series: force = k d (1 + c d), with its slope kept within
    bounds. It can only be pressed and never pulls. With creep, a part of the compression vanishes
    with time."""

    def __init__(self, rig: Rig) -> None:
        self._contact_mm = rig.contact_travel_mm
        self._k = rig.stiffness_N_mm
        self._c = rig.stiffness_curvature_per_mm
        self._crept_mm = 0.0
        self._creep_fraction = rig.creep_fraction
        self._creep_step = STEP_S / rig.creep_time_s
        # Above this compression the slope stays at its bound.
        bound = rig.stiffness_most_N_mm if self._c > 0 else rig.stiffness_least_N_mm
        self._bend_mm = (bound / self._k - 1) / (2 * self._c) if self._c else math.inf
        self._bound_N_mm = bound

    def step(self, travel_mm: float) -> None:
        if self._creep_fraction:
            depth_mm = max(0.0, travel_mm - self._contact_mm)
            self._crept_mm += (self._creep_fraction * depth_mm - self._crept_mm) * self._creep_step

    def force_N(self, travel_mm: float) -> float:
        d = travel_mm - self._contact_mm - self._crept_mm
        if d <= 0:
            return 0.0
        bend = min(d, self._bend_mm)
        force = self._k * bend * (1 + self._c * bend)
        return force + (d - bend) * self._bound_N_mm if d > bend else force

    def stiffness_N_mm(self, travel_mm: float) -> float:
        """Slope of the force; without contact, the slope at first touch."""
        d = max(0.0, travel_mm - self._contact_mm - self._crept_mm)
        return self._k * (1 + 2 * self._c * d) if d < self._bend_mm else self._bound_N_mm


def braking_speed_mm_s(distance_mm: float, deceleration_mm_s2: float) -> float:
    """The highest speed from which the drive, which moves in steps, can still stop within this
    distance."""
    if distance_mm <= 0:
        return 0.0
    per_step = deceleration_mm_s2 * STEP_S
    return math.sqrt(per_step * per_step + 2 * deceleration_mm_s2 * distance_mm) - per_step


class Drive:
    ARRIVED_MM = 1e-7

    def __init__(self, rig: Rig, lies: Honest) -> None:
        self.travel_mm = rig.start_travel_mm
        self.speed_mm_s = 0.0
        self.true_mm_s = 0.0  # true speed of the axis
        self._ends_mm = rig.travel_min_mm, rig.travel_max_mm
        self._faster = rig.acceleration_mm_s2 * STEP_S
        self._slower = rig.deceleration_mm_s2 * STEP_S
        self._deceleration = rig.deceleration_mm_s2
        self._lies = lies

    def step(self, wanted_mm_s: float) -> None:
        """One step at the wanted speed, as far as acceleration and deceleration allow it."""
        v = self.speed_mm_s
        change = wanted_mm_s - v
        slowing = v * change < 0
        if slowing and v * wanted_mm_s < 0:
            change = -v  # stop first
        most = self._slower if slowing else self._faster
        self.speed_mm_s = v + max(-most, min(most, change))
        self.true_mm_s = self._lies.driven_mm_s(self.speed_mm_s)
        self.travel_mm += self.true_mm_s * STEP_S
        if self.true_mm_s != self.speed_mm_s:
            self._meet_end()

    def _meet_end(self) -> None:
        """An axis that goes where nothing sent it is stopped at the end of its travel."""
        low, high = self._ends_mm
        if not low <= self.travel_mm <= high:
            self.travel_mm, self.true_mm_s = max(low, min(high, self.travel_mm)), 0.0

    def step_to(self, target_mm: float, speed_mm_s: float) -> bool:
        """One step of a motion to the target. True when the axis stands there."""
        distance = target_mm - self.travel_mm
        if abs(distance) < self.ARRIVED_MM and abs(self.speed_mm_s) <= self._slower:
            self.travel_mm, self.speed_mm_s, self.true_mm_s = target_mm, 0.0, 0.0
            return True
        limit = min(speed_mm_s, braking_speed_mm_s(abs(distance), self._deceleration))
        self.step(math.copysign(limit, distance))
        return False

    def step_within(self, wanted_mm_s: float, low_mm: float, high_mm: float) -> None:
        """One step at the wanted speed that never leaves the range of travel."""
        up = braking_speed_mm_s(high_mm - self.travel_mm, self._deceleration)
        down = braking_speed_mm_s(self.travel_mm - low_mm, self._deceleration)
        self.step(max(-down, min(up, wanted_mm_s)))


class LoadCell:
    """Reading = gain x force + offset + drift + noise - tare, in steps of its resolution."""

    def __init__(self, rig: Rig, seed: int, lies: Honest) -> None:
        self._rig = rig
        self._random = random.Random(f"cell {seed}")
        self._lies = lies
        self.tare_N = 0.0
        self.raw_N = 0.0  # last reading before tare and resolution

    def unloaded_N(self, t_s: float) -> float:
        """The value shown without load and noise."""
        return self._rig.cell_offset_N + self._rig.cell_drift_N_s * t_s - self.tare_N

    def quiet_N(self, t_s: float, force_N: float) -> float:
        """The value shown without noise and resolution."""
        return self._rig.cell_gain_ratio * force_N + self.unloaded_N(t_s)

    def read(self, t_s: float, force_N: float) -> None:
        felt = self.quiet_N(t_s, self._lies.felt_N(t_s, force_N)) + self.tare_N
        noise_N = self._lies.scatter_N(self._rig.cell_noise_N)
        self.raw_N = self._lies.read_N(felt + self._random.gauss(0.0, noise_N))

    def overload(self) -> bool:
        return abs(self.raw_N) > self._rig.cell_nominal_N

    def value_N(self) -> float:
        """The last reading as the device itself uses it."""
        return self.raw_N - self.tare_N

    def shown_N(self) -> float:
        return in_steps(self.value_N(), self._rig.cell_resolution_N)


def in_steps(value: float, step: float) -> float:
    # The second rounding removes the last bits, which no instrument shows.
    return round(round(value / step) * step, 9) if step else value
