# SPDX-License-Identifier: Apache-2.0
"""The controller of the simulated machine. It has no clock and no thread: step() is STEP_S of its
life, and what happens depends on nothing but the seed and the steps at which orders came."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace
from enum import Enum
from typing import Callable, Protocol

from ..backend import (Capabilities, Ended, HoldForce, Motion, Move, MoveToForce, RampForce, Refused,
                       Sample, State, Window)
from .caps import declare
from .force_loop import ForceLoop
from .lies import Honest
from .physics import Drive, LoadCell, Specimen, in_steps
from .rig import STEP_S, Rig

NO_WINDOW = Window(-math.inf, math.inf, -math.inf, math.inf, math.inf)


class Outlet(Protocol):
    """What the device says: to the gateway, and to the witness of the truth."""

    def ended(self, end: Ended) -> None: ...

    def event(self, kind: str, text: str) -> None: ...

    def truth(self, event: str, **fields: object) -> None: ...


class _Mode(Enum):
    STAND = 0  # decelerates, then holds the travel
    TRAVEL = 1  # goes to a travel
    FORCE = 2  # the force loop has the drive


@dataclass
class _Task:
    """A motion that was accepted and has not ended."""

    motion: Motion
    direction: int
    goal_mm: float  # machine's own travel
    speed_mm_s: float
    running: bool = False
    reason: str = ""  # why it is ending; empty: it goes on
    text: str = ""
    contact: bool = False  # of RAMPF: found, standing comes next, then the loop
    crossed_step: int = 0  # of MOVEF: when the true force passed the threshold
    crossed_N: float = 0.0
    brake_step: int = 0


def _steps(seconds: float) -> int:
    return max(0, round(seconds / STEP_S))


class Device:
    def __init__(self, rig: Rig, seed: int, outlet: Outlet) -> None:
        self._rig = rig
        self._outlet = outlet
        self._lies = Honest()
        self._drive = Drive(rig, self._lies)
        self._specimen = Specimen(rig)
        self._cell = LoadCell(rig, seed, self._lies)
        self._zero_mm = rig.travel_zero_mm
        self._cycle_steps = max(1, _steps(rig.device_cycle_s))
        self._watch_steps = max(1, _steps(rig.watch_cycle_s()))
        self._orders: deque[tuple[int, Callable[[], None]]] = deque()
        self._mode = _Mode.STAND
        self._task: _Task | None = None
        self._loop: ForceLoop | None = None
        self._loop_window = NO_WINDOW
        self._loop_ends = False  # a hold left its limits, the order to end it is on its way
        self._at_rest_N: deque[float] = deque(maxlen=max(1, round(
            rig.zero_average_s / (self._cycle_steps * STEP_S))))
        self._overload = False
        self._stood = True
        self.step_count = 0
        self.motions = 0
        self.force_N = self._specimen.force_N(self._drive.travel_mm)
        self.peak_force_N = self.force_N
        self.max_travel_mm = self._drive.travel_mm
        self._cell.read(0.0, self.force_N)

    # --- what it knows ---

    @property
    def t_s(self) -> float:
        return self.step_count * STEP_S

    @property
    def travel_mm(self) -> float:
        """True, machine's own."""
        return self._drive.travel_mm

    def moving(self) -> bool:
        """Until it stands; a force that is held does not count."""
        seeks = self._loop is not None and not self._loop.settled
        stands = self._mode is not _Mode.STAND or self._lies.stands(self._drive.speed_mm_s)
        return bool(self._task or seeks or not stands)

    def turning(self) -> bool:
        """The drive truly turns."""
        return self._drive.speed_mm_s != 0.0

    def device_s(self) -> float | None:
        if not self._rig.device_clock:
            return None
        return round(self._rig.clock_start_s + self.t_s * (1 + self._rig.clock_error_ppm * 1e-6), 9)

    def shown_force_N(self) -> float | None:
        return None if self._overload else self._cell.shown_N()

    def shown_travel_mm(self) -> float:
        return in_steps(self._drive.travel_mm - self._zero_mm, self._rig.travel_resolution_mm)

    def state(self) -> State:
        # An order on its way may set it in motion, or end a force that is held.
        moving = self.moving() or bool(self._orders)
        return State(moving, self._loop is not None, self.shown_force_N(), self.shown_travel_mm(),
                     self._overload, 5 * self._rig.cell_noise_N + self._rig.cell_resolution_N,
                     self._lies.not_ready(self.t_s), self.device_s())

    def sample(self) -> Sample:
        return Sample(self.device_s(), self.shown_force_N(), self.shown_travel_mm(), self.moving(),
                      self._loop is not None, self._overload)

    def capabilities(self) -> Capabilities:
        return declare(self._rig, self._zero_mm)

    # --- orders: the drive follows after its reaction time ---

    def start(self, motion: Motion) -> None:
        if self._task:
            raise Refused("busy", "the machine is moving")
        self._task = self._new_task(motion)
        self._order(self._begin)

    def hold_force(self, hold: HoldForce) -> None:
        if self._task:
            raise Refused("busy", "the machine is moving")
        rate_N_s = self._rig.loop_rate_max_N_s
        self._order(lambda: self._begin_loop(hold.force_N, rate_N_s, hold.window))

    def stop(self) -> None:
        self._order(lambda: self._brake("stop", ""))

    def arm(self, window: Window) -> None:
        if self._loop and not self._task:
            self._loop_window = self._for_hold(window, self._loop.target_N)

    def zero(self, force: bool, travel: bool) -> None:
        if self.moving() or self._loop or self._orders:
            raise Refused("busy", "the machine does not stand")
        if force:
            readings = self._at_rest_N or [self._cell.raw_N]
            self._cell.tare_N = self._lies.tared_N(sum(readings) / len(readings))
        if travel:
            self._zero_mm = self._drive.travel_mm
        self._outlet.truth("zero", force=force, travel=travel, tare_N=self._cell.tare_N,
                           travel_zero_mm=self._zero_mm)

    def _order(self, call: Callable[[], None], delay_s: float = 0.0) -> None:
        """Kept by the step at which they are due: a STOP overtakes what a slow watch has ordered."""
        due = self.step_count + _steps(delay_s + self._rig.drive_reaction_s)
        place = sum(1 for other, _ in self._orders if other <= due)
        self._orders.insert(place, (due, call))

    def _new_task(self, motion: Motion) -> _Task:
        low, high = self._range_mm(motion.window)
        if isinstance(motion, Move):
            goal = motion.travel_mm + self._zero_mm
            direction = 1 if goal > self._drive.travel_mm else -1
            speed = min(motion.speed_mm_s, self._rig.speed_max_mm_s)
            return _Task(motion, direction, max(low, min(high, goal)), speed)
        if isinstance(motion, MoveToForce):
            direction = 1 if motion.speed_mm_s > 0 else -1
            goal = max(low, min(high, motion.guard_mm + self._zero_mm))
            return _Task(motion, direction, goal, abs(motion.speed_mm_s))
        return _Task(motion, 1, high, min(self._rig.loop_speed_mm_s, motion.window.speed_max_mm_s))

    def _range_mm(self, window: Window) -> tuple[float, float]:
        """Machine's own travel within which a motion stays."""
        return (max(self._rig.travel_min_mm, window.travel_min_mm + self._zero_mm),
                min(self._rig.travel_max_mm, window.travel_max_mm + self._zero_mm))

    # --- one step ---

    def step(self) -> None:
        self.step_count += 1
        while self._orders and self._orders[0][0] <= self.step_count:
            self._orders.popleft()[1]()
        self._specimen.step(self._drive.travel_mm)
        self._drive_step()
        self.force_N = self._specimen.force_N(self._drive.travel_mm)
        if self.force_N > self.peak_force_N:
            self.peak_force_N = self.force_N
        self._note_crossing()
        if self.step_count % self._cycle_steps == 0:
            self._cycle()

    def _drive_step(self) -> None:
        if self._mode is _Mode.STAND:
            if self._drive.speed_mm_s:
                self._drive.step(0.0)
        elif self._mode is _Mode.FORCE:
            assert self._loop is not None
            limit = self._loop_window.speed_max_mm_s
            wanted = max(-limit, min(limit, self._loop.speed_mm_s))
            self._drive.step_within(wanted, *self._range_mm(self._loop_window))
        elif self._task and self._drive.step_to(self._task.goal_mm, self._task.speed_mm_s):
            self._arrived(self._task)
        self.max_travel_mm = max(self.max_travel_mm, self._drive.travel_mm)

    def _arrived(self, task: _Task) -> None:
        self._mode = _Mode.STAND
        if not task.reason:
            task.reason = "target" if isinstance(task.motion, Move) else "travel_limit"

    def _note_crossing(self) -> None:
        task = self._task
        if not task or task.crossed_step or not task.running or not isinstance(task.motion, MoveToForce):
            return
        quiet_N = self._cell.quiet_N(self.t_s, self.force_N)
        if (quiet_N - task.motion.force_N) * task.direction >= 0:
            task.crossed_step, task.crossed_N = self.step_count, self.force_N

    def _cycle(self) -> None:
        """Once per cycle of the controller: read, watch, control, see whether it stands."""
        self._cell.read(self.t_s, self.force_N)
        self._see_overload()
        if self._loop:
            self._loop.cycle(self.t_s, self._cell.value_N(),
                             self._specimen.stiffness_N_mm(self._drive.travel_mm))
        if self.step_count % self._watch_steps == 0:
            self._watch()
        stands = self._mode is _Mode.STAND and self._lies.stands(self._drive.speed_mm_s)
        if stands:
            self._at_rest_N.append(self._cell.raw_N)
        else:
            self._at_rest_N.clear()
        self._see_standstill(stands)
        self._see_ramp_end()

    def _see_overload(self) -> None:
        overload = self._cell.overload()
        if overload and not self._overload:
            self._outlet.event("overload", "the load cell is beyond its range")
        self._overload = overload

    def _see_standstill(self, stands: bool) -> None:
        if stands and not self._stood:
            self._outlet.truth("standing")
        self._stood = stands
        task = self._task
        if not stands or not task or not task.running:
            return
        if task.reason:
            self._end(task)
        elif task.contact and isinstance(task.motion, RampForce):
            self._begin_loop(task.motion.force_N, task.motion.rate_N_s, task.motion.window)

    def _see_ramp_end(self) -> None:
        loop = self._loop
        if not loop:
            return
        task = self._task if self._task and self._task.running else None
        if task and not task.reason and loop.settled:
            task.reason = "target"
            self._end(task)
            self._loop_window = self._for_hold(task.motion.window, loop.target_N)
        else:
            self._see_loop_at_its_end(task, loop)

    def _see_loop_at_its_end(self, task: _Task | None, loop: ForceLoop) -> None:
        """Force control that would have to leave the limits of travel holds the travel there."""
        low, high = self._range_mm(self._loop_window)
        at = self._drive.travel_mm
        outwards = high - at if loop.speed_mm_s > 0 else at - low
        if outwards > Drive.ARRIVED_MM:
            return
        if not task:
            self._outlet.event("travel_limit", "the held force led to a limit of travel")
        self._brake("travel_limit", "")

    # --- motions ---

    def _begin(self) -> None:
        task = self._task
        if not task:
            return
        task.running = True
        self._loop = None
        self._stood = False
        self.motions += 1
        self._outlet.truth("motion_begin", token=task.motion.token, motion=type(task.motion).__name__)
        self._mode = _Mode.TRAVEL
        if isinstance(task.motion, RampForce) and self._cell.value_N() >= self._rig.loop_contact_N:
            self._begin_loop(task.motion.force_N, task.motion.rate_N_s, task.motion.window)
        elif isinstance(task.motion, MoveToForce):
            finding = self._finding(task)
            if finding == ("target", ""):
                task.reason, self._mode = "target", _Mode.STAND
            elif (task.goal_mm - self._drive.travel_mm) * task.direction <= 0:
                task.reason, self._mode = "travel_limit", _Mode.STAND

    def _begin_loop(self, target_N: float, rate_N_s: float, window: Window) -> None:
        tolerance_N = self._rig.loop_ripple_N + 4 * self._rig.cell_noise_N + self._rig.cell_resolution_N
        self._loop = ForceLoop(self._rig, self._cell.value_N(), target_N, rate_N_s, tolerance_N)
        self._loop_ends = False
        self._mode = _Mode.FORCE
        if self._task:
            self._loop_window = window
        else:
            self.motions += 1
            self._loop_window = self._for_hold(window, target_N)
        self._outlet.truth("force_control", target_N=target_N, rate_N_s=rate_N_s)

    def _for_hold(self, window: Window, target_N: float) -> Window:
        """A force that is held goes on being held, even where new limits exclude it."""
        loop = self.capabilities().loop
        band_N = 2 * loop.force_ripple_N if loop else 0.0
        return replace(window, force_min_N=min(window.force_min_N, target_N - band_N),
                       force_max_N=max(window.force_max_N, target_N + band_N))

    def _watch(self) -> None:
        task = self._task
        if task and (not task.running or task.reason or task.contact and not self._loop):
            return
        if not task and (not self._loop or self._loop_ends):
            return
        finding = self._finding(task)
        if finding is None:
            return
        if task and finding[0] == "contact":
            task.contact = True
        elif task:
            task.reason, task.text = finding
        else:
            self._loop_ends = True
            self._outlet.event(finding[0], "the held force left its limits")
        self._brake_soon(task, *finding)

    def _finding(self, task: _Task | None) -> tuple[str, str] | None:
        """What the last reading says about the motion under way."""
        value_N = self._cell.value_N()
        window = task.motion.window if task and not self._loop else self._loop_window
        direction = task.direction if task and not self._loop else 0
        if task and isinstance(task.motion, MoveToForce):
            if (value_N - task.motion.force_N) * task.direction >= 0:
                return "target", ""
        if self._overload and direction >= 0:
            return "force_limit", "load cell beyond its range"
        if value_N > window.force_max_N or value_N < window.force_min_N:
            return "force_limit", ""
        if task and isinstance(task.motion, RampForce) and not self._loop:
            return ("contact", "") if value_N >= self._rig.loop_contact_N else None
        return None

    def _brake_soon(self, task: _Task | None, reason: str, text: str) -> None:
        """The order goes out after the reaction of the watch; a motion begun later is not meant."""
        loop = self._loop

        def brake() -> None:
            if self._task is task and self._loop is loop:
                self._brake(reason, text)

        self._order(brake, self._rig.watch_reaction_s())

    def _brake(self, reason: str, text: str) -> None:
        self._outlet.truth("stop_begun", reason=reason, speed_mm_s=self._drive.speed_mm_s)
        self._mode = _Mode.STAND
        self._loop = None
        self._stood = False
        task = self._task
        if not task:
            return
        task.brake_step = task.brake_step or self.step_count
        if reason != "contact" and not task.reason:
            task.reason, task.text = reason, text

    def _end(self, task: _Task) -> None:
        self._task = None
        self._outlet.truth("motion_end", token=task.motion.token, reason=task.reason)
        if isinstance(task.motion, MoveToForce):
            self._tell_force_stop(task, task.motion)
        self._outlet.ended(Ended(task.motion.token, task.reason, task.text, self.shown_force_N(),
                                 self.shown_travel_mm()))

    def _tell_force_stop(self, task: _Task, motion: MoveToForce) -> None:
        crossed = task.crossed_step > 0
        reaction_s = (task.brake_step - task.crossed_step) * STEP_S
        self._outlet.truth(
            "force_stop", token=motion.token, reason=task.reason, threshold_N=motion.force_N,
            speed_mm_s=motion.speed_mm_s, end_force_N=self.force_N,
            crossed_force_N=task.crossed_N if crossed else None,
            reaction_s=round(reaction_s, 6) if crossed and task.brake_step else None)
