# SPDX-License-Identifier: Apache-2.0
"""Drive, specimen and load cell together: their true state, and what is shown of it."""

from __future__ import annotations

from .lies import Honest
from .physics import Drive, LoadCell, Specimen, in_steps
from .rig import STEP_S, Rig


class Body:
    def __init__(self, rig: Rig, seed: int, lies: Honest) -> None:
        self._rig = rig
        self._lies = lies
        self._drive = Drive(rig, lies)
        self._specimen = Specimen(rig)
        self._cell = LoadCell(rig, seed, lies)
        self._zero_mm = rig.travel_zero_mm
        self._overload = False
        self.step_count = 0
        self.force_N = self.peak_force_N = self._specimen.force_N(self._drive.travel_mm)
        self.max_travel_mm = self._drive.travel_mm
        self._cell.read(0.0, self.force_N)

    @property
    def t_s(self) -> float:
        return self.step_count * STEP_S

    @property
    def travel_mm(self) -> float:
        """True travel, in the machine's own coordinates."""
        return self._drive.travel_mm

    def turning(self) -> bool:
        """The axis is really moving."""
        return self._drive.true_mm_s != 0.0

    def device_s(self) -> float | None:
        if not self._rig.device_clock:
            return None
        clock_s = self._rig.clock_start_s + self.t_s * (1 + self._rig.clock_error_ppm * 1e-6)
        return round(self._lies.clock_s(clock_s), 9)

    def shown_force_N(self) -> float | None:
        return None if self._overload else self._cell.shown_N()

    def shown_travel_mm(self) -> float:
        return in_steps(self._drive.travel_mm - self._zero_mm, self._rig.travel_resolution_mm)

    def _feel(self) -> None:
        """Called after the axis has made its step."""
        self.force_N = self._specimen.force_N(self._drive.travel_mm)
        self.peak_force_N = max(self.peak_force_N, self.force_N)
        self.max_travel_mm = max(self.max_travel_mm, self._drive.travel_mm)
