# SPDX-License-Identifier: Apache-2.0
"""One motion of the simulated device: what was asked, its progress, and what a reading says about
it."""

from __future__ import annotations

from dataclasses import dataclass

from ..backend import Ended, Motion, Move, MoveToForce, RampForce, Window
from .rig import STEP_S, Rig


@dataclass
class Task:
    """A motion that was accepted and has not ended."""

    motion: Motion
    direction: int
    goal_mm: float  # machine's own travel
    speed_mm_s: float
    running: bool = False
    reason: str = ""  # why it is ending; empty while it goes on
    text: str = ""
    contact: bool = False  # for RAMPF: contact was found, then comes standstill, then the loop
    crossed_step: int = 0  # for MOVEF: step at which the true force passed the threshold
    crossed_N: float = 0.0
    brake_step: int = 0
    begin_step: int = 0
    told: bool = False  # for a lie: DONE was already sent
    hidden: bool = False  # for a lie: it goes on, while the machine says that it stands
    asleep: bool = False  # for a lie: it begins later or never

    def truth(self, end_N: float) -> dict[str, object]:
        """For the record of the truth: how the force ended a MOVEF."""
        motion, crossed = self.motion, self.crossed_step > 0
        assert isinstance(motion, MoveToForce)
        reaction_s = (self.brake_step - self.crossed_step) * STEP_S
        return {
            "token": motion.token, "reason": self.reason, "threshold_N": motion.force_N,
            "speed_mm_s": motion.speed_mm_s, "end_force_N": end_N,
            "crossed_force_N": self.crossed_N if crossed else None,
            "reaction_s": round(reaction_s, 6) if crossed and self.brake_step else None}


def range_mm(rig: Rig, window: Window, zero_mm: float) -> tuple[float, float]:
    """The range of travel that a motion must not leave, in the machine's own coordinates."""
    return (max(rig.travel_min_mm, window.travel_min_mm + zero_mm),
            min(rig.travel_max_mm, window.travel_max_mm + zero_mm))


def plan(rig: Rig, motion: Motion, at_mm: float, zero_mm: float) -> Task:
    """The task of a motion that begins at at_mm, in the machine's own coordinates."""
    low, high = range_mm(rig, motion.window, zero_mm)
    if isinstance(motion, Move):
        goal = motion.travel_mm + zero_mm
        direction = 1 if goal > at_mm else -1
        speed = min(motion.speed_mm_s, rig.speed_max_mm_s)
        return Task(motion, direction, max(low, min(high, goal)), speed)
    if isinstance(motion, MoveToForce):
        direction = 1 if motion.speed_mm_s > 0 else -1
        goal = max(low, min(high, motion.guard_mm + zero_mm))
        return Task(motion, direction, goal, abs(motion.speed_mm_s))
    return Task(motion, 1, high, min(rig.loop_speed_mm_s, motion.window.speed_max_mm_s))


def finding(task: Task | None, loop_window: Window | None, value_N: float, overload: bool,
            contact_N: float) -> tuple[str, str] | None:
    """What a reading means for the motion under way: reason and text of its end, or None.
    loop_window: bounds of the force loop if it has the drive, otherwise None."""
    direction = task.direction if task and not loop_window else 0
    if task and isinstance(task.motion, MoveToForce):
        if (value_N - task.motion.force_N) * task.direction >= 0:
            return "target", ""
    if overload and direction >= 0:
        return "force_limit", "load cell beyond its range"
    window = loop_window or (task.motion.window if task else None)
    if window and (value_N > window.force_max_N or value_N < window.force_min_N):
        return "force_limit", ""
    if task and isinstance(task.motion, RampForce) and not loop_window:
        return ("contact", "") if value_N >= contact_N else None
    return None


def claimed(task: Task, force_N: float | None, travel_mm: float) -> Ended:
    """For a lie: the end of a motion that did not take place, as if it had reached its target."""
    motion = task.motion
    if isinstance(motion, Move):
        travel_mm = motion.travel_mm
    else:
        force_N = motion.force_N
    return Ended(motion.token, "target", "", force_N, travel_mm)
