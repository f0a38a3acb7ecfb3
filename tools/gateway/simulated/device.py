# SPDX-License-Identifier: Apache-2.0
"""The controller of the simulated machine. It has no clock and no thread: step() simulates STEP_S.
What happens depends only on the seed and on the steps at which orders came."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from enum import Enum
from functools import partial
from typing import Callable

from ..backend import (Capabilities, Ended, HoldForce, Motion, Move, MoveToForce, RampForce, Refused,
                       Sample, State, Window)
from .body import Body
from .caps import declare
from .force_loop import ForceLoop
from .lies import Honest
from .orders import Orders
from .outlet import Outlet
from .physics import Drive
from .rig import STEP_S, Rig
from .task import Task, claimed, finding, plan, range_mm

NO_WINDOW = Window(-math.inf, math.inf, -math.inf, math.inf, math.inf)


class _Mode(Enum):
    STAND = 0  # decelerates, then holds the travel
    TRAVEL = 1  # goes to a travel
    FORCE = 2  # the force loop has the drive


def _steps(seconds: float) -> int:
    return max(0, round(seconds / STEP_S))


class Device(Body):
    def __init__(self, rig: Rig, seed: int, outlet: Outlet, lies: Honest | None = None) -> None:
        super().__init__(rig, seed, lies or Honest())
        self._outlet = outlet
        self._cycle_steps = max(1, _steps(rig.device_cycle_s))
        self._watch_steps = max(1, _steps(rig.watch_cycle_s()))
        self._orders = Orders()
        self._late: deque[tuple[int, Task]] = deque()  # for a lie: motions that begin later
        self._accepted = self._accepted_step = 0
        self._mode = _Mode.STAND
        self._task: Task | None = None
        self._loop: ForceLoop | None = None
        self._loop_window = NO_WINDOW
        self._loop_ends = False  # a hold left its limits, and the order to end it was given
        self._at_rest_N: deque[float] = deque(maxlen=max(1, round(
            rig.zero_average_s / (self._cycle_steps * STEP_S))))
        self._stood = True
        self.motions = 0

    # --- what it knows ---

    def moving(self) -> bool:
        """Until the device says that it stands. A force that is held does not count."""
        task = self._task
        if task and task.hidden:
            return False
        begins = task is not None and not task.asleep
        seeks = self._loop is not None and not self._loop.settled
        brakes = self._mode is _Mode.STAND and self._drive.speed_mm_s != 0.0
        return begins or seeks or brakes

    def state(self) -> State:
        # An order that is not yet carried out may start a motion or end a force that is held.
        moving = self.moving() or bool(self._orders)
        return State(moving, self._loop is not None, self.shown_force_N(), self.shown_travel_mm(),
                     self._overload, 5 * self._rig.cell_noise_N + self._rig.cell_resolution_N,
                     self._lies.not_ready(), self.device_s())

    def sample(self) -> Sample:
        return Sample(self.device_s(), self.shown_force_N(), self.shown_travel_mm(), self.moving(),
                      self._loop is not None, self._overload)

    def capabilities(self) -> Capabilities:
        return self._lies.declares(declare(self._rig, self._zero_mm))

    # --- orders: the drive follows after its reaction time ---

    def start(self, motion: Motion) -> None:
        self._accept()
        task = plan(self._rig, motion, self._drive.travel_mm, self._zero_mm)
        delay_s = self._lies.order_delay_s()
        if self._task:  # DONE was sent too early, and it still moves
            self._mode, self._loop = _Mode.STAND, None
        self._task = task
        if delay_s:
            task.asleep = True
            self._late.append((self.step_count + _steps(delay_s), task))
        else:
            self._order(self._begin)

    def hold_force(self, hold: HoldForce) -> None:
        self._accept()
        rate_N_s = self._rig.loop_rate_max_N_s
        self._order(lambda: self._begin_loop(hold.force_N, rate_N_s, hold.window))

    def _accept(self) -> None:
        if self._task and not self._task.told:
            raise Refused("busy", "the machine is moving")
        self._accepted, self._accepted_step = self._accepted + 1, self.step_count
        self._follow_lies()
        if self._lies.not_ready():
            raise Refused("not_ready", self._lies.not_ready())

    def stop(self) -> None:
        delay_s = self._lies.stop_delay_s()
        if delay_s < math.inf:
            self._order(self._carry_out_stop, delay_s)

    def _carry_out_stop(self) -> None:
        self._lies.stopped()
        self._brake("stop", "")

    def arm(self, window: Window) -> None:
        if self._loop and not self._task:
            self._loop_window = self._for_hold(window, self._loop.target_N)

    def zero(self, force: bool, travel: bool) -> None:
        if self.moving() or self._loop or self._orders:
            raise Refused("busy", "the machine does not stand")
        if force:
            readings = self._at_rest_N or [self._cell.raw_N]
            self._cell.tare_N = sum(readings) / len(readings)
        if travel:
            self._zero_mm = self._drive.travel_mm
        self._outlet.truth("zero", force=force, travel=travel, tare_N=self._cell.tare_N,
                           travel_zero_mm=self._zero_mm)

    def _order(self, call: Callable[[], None], delay_s: float = 0.0) -> None:
        self._orders.put(self.step_count + _steps(delay_s + self._rig.drive_reaction_s), call)

    def _range_mm(self, window: Window) -> tuple[float, float]:
        return range_mm(self._rig, window, self._zero_mm)

    # --- Victim: what a lie does to it ---

    def trip(self, kind: str, text: str) -> None:
        self._outlet.event(kind, text)
        self._late.clear()
        self._brake("fault", text)

    def forget_tare(self, told: bool) -> None:
        self._cell.tare_N = 0.0
        if told:
            self._outlet.forget_origin()

    def restart_link(self) -> None:
        self._outlet.restart_link()

    def note_lie(self, name: str, on: bool) -> None:
        self._outlet.truth("lie", name=name, on=on)

    def _follow_lies(self) -> None:
        since_s = (self.step_count - self._accepted_step) * STEP_S
        self._lies.follow(self.t_s, self._accepted, since_s, self)

    # --- one step ---

    def step(self) -> None:
        self.step_count += 1
        self._follow_lies()
        self._orders.carry_out(self.step_count)
        self._begin_late()
        self._specimen.step(self._drive.travel_mm)
        self._drive_step()
        self._feel()
        self._note_crossing()
        if self.step_count % self._cycle_steps == 0:
            self._cycle()

    def _drive_step(self) -> None:
        if self._mode is _Mode.STAND:
            self._drive.step(0.0)
        elif self._mode is _Mode.FORCE:
            assert self._loop is not None
            limit = self._loop_window.speed_max_mm_s
            wanted = max(-limit, min(limit, self._loop.speed_mm_s))
            self._drive.step_within(wanted, *self._range_mm(self._loop_window))
        elif self._task and self._drive.step_to(self._task.goal_mm, self._task.speed_mm_s):
            self._arrived(self._task)

    def _arrived(self, task: Task) -> None:
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
        """Once per cycle of the controller: read, watch, control, and see whether the axis
        stands."""
        self._cell.read(self.t_s, self.force_N)
        self._see_overload()
        if self._loop:
            self._loop.cycle(self.t_s, self._cell.value_N(),
                             self._specimen.stiffness_N_mm(self._drive.travel_mm))
        if self.step_count % self._watch_steps == 0:
            self._watch()
        stands = self._mode is _Mode.STAND and self._drive.speed_mm_s == 0.0
        if stands:
            self._at_rest_N.append(self._cell.raw_N)
        else:
            self._at_rest_N.clear()
        self._see_standstill(stands)
        self._see_ramp_end()
        self._tell_early()

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

    def _see_loop_at_its_end(self, task: Task | None, loop: ForceLoop) -> None:
        """Force control that would leave the limits of travel holds the travel there."""
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
        false_done_s = self._lies.false_done_s()
        task.asleep = false_done_s is not None
        if false_done_s is not None:
            self._order(partial(self._tell_false, task), false_done_s)
            return
        task.running, task.begin_step = True, self.step_count
        if task.reason:
            return  # it was ended before it began
        self._loop = None
        self._stood = False
        self.motions += 1
        self._outlet.truth("motion_begin", token=task.motion.token, motion=type(task.motion).__name__)
        self._mode = _Mode.TRAVEL
        if isinstance(task.motion, RampForce) and self._cell.value_N() >= self._rig.loop_contact_N:
            self._begin_loop(task.motion.force_N, task.motion.rate_N_s, task.motion.window)
        elif isinstance(task.motion, MoveToForce):
            if self._finding(task) == ("target", ""):
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
        """A force that is held stays held, even if new limits exclude it."""
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
        found = self._finding(task)
        if found is None:
            return
        if task and found[0] == "contact":
            task.contact = True
        elif task:
            task.reason, task.text = found
        else:
            self._loop_ends = True
            self._outlet.event(found[0], "the held force left its limits")
        self._brake_soon(task, *found)

    def _finding(self, task: Task | None) -> tuple[str, str] | None:
        """What the last reading says about the motion under way."""
        loop_window = self._loop_window if self._loop else None
        return finding(task, loop_window, self._cell.value_N(), self._overload,
                       self._rig.loop_contact_N)

    def _brake_soon(self, task: Task | None, reason: str, text: str) -> None:
        """The order is carried out after the watch's reaction time. It does not stop a motion begun
        later."""
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
        if task.asleep:
            self._task, task.told = None, True
            self._tell(Ended(task.motion.token, reason, text, self.shown_force_N(),
                             self.shown_travel_mm()))
        elif reason != "contact" and not task.reason:
            task.reason, task.text = reason, text

    def _end(self, task: Task) -> None:
        self._task = None
        self._outlet.truth("motion_end", token=task.motion.token, reason=task.reason)
        if isinstance(task.motion, MoveToForce):
            self._outlet.truth("force_stop", **task.truth(self.force_N))
        if not task.told:
            self._tell(Ended(task.motion.token, task.reason, task.text, self.shown_force_N(),
                             self.shown_travel_mm()))

    def _tell(self, end: Ended) -> None:
        self._lies.done_told()
        self._outlet.ended(end)

    # --- motions of a lie ---

    def _begin_late(self) -> None:
        """Begins a motion that was accepted earlier and may have been stopped since."""
        if not self._late or self._late[0][0] > self.step_count:
            return
        task = self._late[0][1]
        if self._task is task or not self._task:
            self._late.popleft()
            self._task = task
            self._begin()

    def _tell_early(self) -> None:
        task = self._task
        if not task or not task.running or task.reason or task.told:
            return
        if self._lies.ends_early((self.step_count - task.begin_step) * STEP_S):
            task.told, task.hidden = True, self._lies.hides_motion()
            self._tell(Ended(task.motion.token, "target", "", self.shown_force_N(),
                             self.shown_travel_mm()))

    def _tell_false(self, task: Task) -> None:
        if self._task is not task:
            return
        self._task = None
        end = Ended(task.motion.token, "target", "", self.shown_force_N(), self.shown_travel_mm())
        if self._lies.claims_target():
            end = claimed(task, self.shown_force_N(), self.shown_travel_mm())
        self._tell(end)
