# SPDX-License-Identifier: Apache-2.0
"""The one place for a machine that lies or breaks. An honest machine passes every value on.

A lie is a subclass that overrides one of these, chosen by a parameter of the rig: a frozen or
reversed force (felt_N), a stalled or reversed drive (driven_mm_s), DONE too early (stands), creep
after DONE (driven_mm_s of a drive that stands), a lost tare (tared_N), an E-stop (not_ready).
"""

from __future__ import annotations


class Honest:
    def felt_N(self, t_s: float, force_N: float) -> float:
        """What the load cell makes of the force, before its noise."""
        return force_N

    def driven_mm_s(self, speed_mm_s: float) -> float:
        """How fast the crosshead goes when the drive turns so fast."""
        return speed_mm_s

    def stands(self, speed_mm_s: float) -> bool:
        """Whether the machine says that it stands."""
        return speed_mm_s == 0.0

    def tared_N(self, tare_N: float) -> float:
        """The tare that is kept after ZERO."""
        return tare_N

    def not_ready(self, t_s: float) -> str:
        """Why it cannot move; empty: it can."""
        return ""
