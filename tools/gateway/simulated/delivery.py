# SPDX-License-Identifier: Apache-2.0
"""Samples on their way from the simulated device to the gateway: taken, corrupted, delayed."""

from __future__ import annotations

import math
import random
from collections import deque
from dataclasses import replace
from typing import Callable, Union

from ..backend import Ended, Sample
from .lies import Honest
from .rig import STEP_S, Rig

Item = Union[Sample, Ended]


class Sampler:
    """Decides when samples are due, and which are lost or lack values."""

    def __init__(self, rig: Rig, seed: int) -> None:
        self._rig = rig
        self._random = random.Random(f"samples {seed}")
        self._period_steps = 0.0
        self._due_step = math.inf
        self._lost = 0

    def set_rate(self, hz: float, step_count: int) -> None:
        # The device counts its own seconds, which are shorter by clock_error_ppm.
        self._period_steps = 1 / (hz * (1 + self._rig.clock_error_ppm * 1e-6) * STEP_S) if hz else 0.0
        self._due_step = step_count + self._period_steps if hz else math.inf
        self._lost = 0

    def take(self, step_count: int, sample: Callable[[], Sample]) -> Sample | None:
        """Must be called after every step."""
        if step_count < self._due_step:
            return None
        self._due_step += self._period_steps
        if self._random.random() < self._rig.lost_probability:
            self._lost += 1
            return None
        lost, self._lost = self._lost, 0
        return self._spoilt(replace(sample(), lost_before=lost))

    def _spoilt(self, sample: Sample) -> Sample:
        rig, chance = self._rig, self._random.random
        if chance() < rig.missing_t_probability:
            sample = replace(sample, t_s=None)
        if chance() < rig.missing_force_probability:
            sample = replace(sample, force_N=None)
        if chance() < rig.missing_travel_probability:
            sample = replace(sample, travel_mm=None)
        if chance() < rig.missing_flags_probability:
            sample = replace(sample, flags_known=False)
        return sample


class Delivery:
    """Hands items over in order after a delay, samples also in bursts. The end of a motion does not
    wait for the next burst, and takes the samples before it along."""

    def __init__(self, rig: Rig, lies: Honest | None = None) -> None:
        self._lies = lies or Honest()
        self._latest_s = 0.0  # a sample never overtakes the one before it
        self._delay_s = rig.delivery_delay_s
        self._period_s = rig.burst_period_s
        self._items: deque[tuple[float, Item]] = deque()

    def put(self, t_s: float, item: Item) -> None:
        if isinstance(item, Ended):
            now_s = t_s + self._delay_s
            if not self._lies.done_overtakes_samples():
                self._items = deque((min(due_s, now_s), waiting) for due_s, waiting in self._items)
            place = sum(1 for due_s, _ in self._items if due_s <= now_s)
            self._items.insert(place, (now_s, item))
            return
        if self._period_s:
            t_s = math.ceil(t_s / self._period_s) * self._period_s
        self._latest_s = max(self._latest_s, self._lies.sample_due_s(t_s) + self._delay_s)
        self._items.append((self._latest_s, item))

    def take(self, t_s: float) -> list[Item]:
        found = []
        while self._items and self._items[0][0] <= t_s:
            found.append(self._items.popleft()[1])
        return found

    def drop_samples(self) -> None:
        self._items = deque(entry for entry in self._items if isinstance(entry[1], Ended))
