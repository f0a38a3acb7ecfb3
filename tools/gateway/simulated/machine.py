# SPDX-License-Identifier: Apache-2.0
"""The simulated machine as a back end: the device in real time, in a thread of its own.

Orders carry the time at which they came and take effect at the next step after it, even when the
thread is late. So what happens depends on the times of the orders and the seed, not on the
computer.
"""

from __future__ import annotations

import math
import sys
import threading
import time
from collections import deque
from concurrent.futures import Future
from dataclasses import replace
from typing import Callable, Sequence

from ..backend import (Backend, Capabilities, Ended, HoldForce, Identity, Listener, Motion, Move,
                       Sample, State, Window)
from .. import __version__
from .delivery import Delivery, Sampler
from .device import NO_WINDOW, Device
from .lies import Lie, Lies
from .rig import STEP_S, Rig
from .truth import LINES_PER_S, Truth

TURN_S = 0.001
MOST_STEPS = 1000  # at once, if the thread is late
PANEL_TOKEN = -1  # for motions that the link did not command


class SimulatedMachine(Backend):
    def __init__(self, rig: Rig, seed: int = 1, truth: Truth | None = None,
                 lies: Lies | None = None) -> None:
        self._rig = rig
        self._lies = lies or Lies()
        # of the server, for a gateway that restarts
        self.hang_up: Callable[[], None] = lambda: None
        self._truth = truth
        self._listener: Listener | None = None
        self._device = Device(rig, seed, self, self._lies)
        self._sampler = Sampler(rig, seed)
        self._delivery = Delivery(rig, self._lies)
        self._state = self._device.state()
        self._capabilities = self._device.capabilities()
        self._orders: deque[tuple[float, Callable[[], None]]] = deque()
        self._late: list[tuple[float, Ended]] = []  # for a lie: DONE that comes later
        self._boot = format(time.time_ns(), "x")
        self._zeros = 0
        self._ending = False
        self._truth_due_s = 0.0
        self._start_s = time.monotonic()
        self._thread = threading.Thread(target=self._run, name="machine", daemon=True)
        if truth:
            truth.clock = self._now_s

    # --- Backend: at once ---

    def stop(self) -> None:
        self._orders.append((self._now_s(), self._stop_device))

    def state(self) -> State:
        # An order that is not yet carried out may change everything.
        return replace(self._state, moving=True) if self._orders else self._state

    def identity(self) -> Identity:
        return Identity(self._rig.maker, self._rig.model, self._rig.serial, __version__, simulated=True)

    def capabilities(self) -> Capabilities:
        return self._capabilities

    def origin(self) -> str:
        # Every start of the program is a machine that has lost its zero.
        return f"{self._boot}-{self._zeros}"

    # --- Backend: may block ---

    def refresh(self) -> None:
        if self._rig.answer_delay_s:
            time.sleep(self._rig.answer_delay_s)

    def arm(self, window: Window) -> None:
        self._call(lambda: self._device.arm(window))

    def start(self, motion: Motion) -> None:
        self._call(lambda: self._device.start(motion))

    def hold_force(self, hold: HoldForce) -> None:
        self._call(lambda: self._device.hold_force(hold))

    def zero(self, force: bool, travel: bool) -> None:
        self._call(lambda: self._zero(force, travel))

    def set_rate(self, hz: float) -> None:
        self._call(lambda: self._set_rate(hz))

    def open(self, listener: Listener) -> None:
        self._listener = listener
        self.truth("started", monotonic_s=self._start_s)
        self._thread.start()

    def close(self) -> None:
        """The device is gone, so nothing moves. Waits for standstill, because a test asks for the
        place."""
        self.stop()
        deadline_s = self._now_s() + 2.0
        while self.state().moving and self._now_s() < deadline_s:
            time.sleep(0.002)
        self._ending = True
        self._thread.join()
        for name in self._lies.untold():
            print(f"lcrig-gateway: warning: lie {name} had no occasion", file=sys.stderr)

    # --- what a person at the machine can do (panel.py) ---

    def panel_move(self, travel_mm: float, speed_mm_s: float) -> None:
        self.start(Move(PANEL_TOKEN, NO_WINDOW, travel_mm, speed_mm_s))

    def panel_zero(self, force: bool, travel: bool) -> None:
        self.zero(force, travel)
        if self._listener:
            self._listener.origin_changed(self.origin(), "zeroed at the panel")

    def panel_lie(self, lie: Lie) -> None:
        """The lie begins at its own time, or now if that has passed."""
        self._call(lambda: self._lies.add(lie))

    # --- Outlet: for the device, in the machine's thread ---

    def ended(self, end: Ended) -> None:
        delay_s = self._lies.done_delay_s() if end.reason != "stop" else 0.0
        if delay_s:
            self._late.append((self._device.t_s + delay_s, end))
        else:
            self._delivery.put(self._device.t_s, end)

    def forget_origin(self) -> None:
        self._zeros += 1
        if self._listener:
            self._listener.origin_changed(self.origin(), "the tare was lost")

    def restart_link(self) -> None:
        self._capabilities = self._device.capabilities()
        self.hang_up()

    def event(self, kind: str, text: str) -> None:
        if self._listener:
            self._listener.event(kind, text)

    def truth(self, event: str, **fields: object) -> None:
        if event == "lie":
            print(f"lcrig-gateway: lie {fields['name']} {'begins' if fields['on'] else 'ends'} at "
                  f"{self._device.t_s:.3f} s", file=sys.stderr, flush=True)
        if self._truth:
            device = self._device
            self._truth.put(event, **fields, state={
                "t_s": round(device.t_s, 6), "force_N": device.force_N, "travel_mm": device.travel_mm,
                "peak_force_N": device.peak_force_N, "moving": device.moving() or device.turning(),
                "turning": device.turning(), "max_travel_mm": device.max_travel_mm,
                "motions": device.motions})

    # --- the thread ---

    def _now_s(self) -> float:
        return time.monotonic() - self._start_s

    def _run(self) -> None:
        while not self._ending:
            self._advance(self._now_s())
            self._hand_over()
            time.sleep(TURN_S)

    def _advance(self, until_s: float) -> None:
        device = self._device
        steps = int(until_s / STEP_S) - device.step_count
        for _ in range(min(steps, MOST_STEPS)):
            while self._orders and self._orders[0][0] <= device.t_s:
                self._orders[0][1]()  # removed only when it is done: see state()
                self._orders.popleft()
            device.step()
            sample = self._sampler.take(device.step_count, device.sample)
            if sample:
                self._delivery.put(device.t_s, sample)
            if device.t_s >= self._truth_due_s:
                self._truth_due_s = device.t_s + 1 / LINES_PER_S
                self.truth("")
        self._state = device.state()

    def _hand_over(self) -> None:
        """Passes reports to the gateway, in order."""
        assert self._listener is not None
        self._release_late(self._device.t_s)
        samples: list[Sample] = []
        for item in self._delivery.take(self._device.t_s):
            if isinstance(item, Sample):
                samples.append(item)
                continue
            self._pass_on(samples)
            samples = []
            self._listener.ended(item)
        self._pass_on(samples)

    def _release_late(self, until_s: float) -> None:
        while self._late and self._late[0][0] <= until_s:
            self._delivery.put(self._device.t_s, self._late.pop(0)[1])

    def _pass_on(self, samples: Sequence[Sample]) -> None:
        if samples and self._listener:
            self._listener.samples(samples)

    def _call(self, order: Callable[[], None]) -> None:
        """Lets the machine's thread make the call, and waits for the result."""
        result: Future[None] = Future()

        def carry_out() -> None:
            try:
                order()
                result.set_result(None)
            except Exception as error:
                result.set_exception(error)
            self._state = self._device.state()

        self._orders.append((self._now_s(), carry_out))
        result.result(timeout=5.0)

    def _stop_device(self) -> None:
        self._release_late(math.inf)  # otherwise STOPPED would be late too
        self._device.stop()
        self._state = self._device.state()

    def _zero(self, force: bool, travel: bool) -> None:
        self._device.zero(force, travel)
        self._zeros += 1
        self._capabilities = self._device.capabilities()

    def _set_rate(self, hz: float) -> None:
        if hz == 0:
            self._delivery.drop_samples()
        self._sampler.set_rate(hz, self._device.step_count)
