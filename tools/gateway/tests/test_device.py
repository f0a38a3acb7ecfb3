# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import math
from typing import Any, Callable

from gateway.backend import Ended, ForceLoop, HoldForce, Move, MoveToForce, RampForce, Refused, Window
from gateway.simulated.caps import dishonest
from gateway.simulated.device import Device
from gateway.simulated.lie_options import parse_all
from gateway.simulated.rig import STEP_S, Rig, with_values

WIDE = Window(-20.0, 20.0, 0.0, 60.0, 20.0)


class Bench:
    """A device without real time."""

    def __init__(self, seed: int = 1, *lies: str, **rig: Any) -> None:
        self.rig = with_values(Rig(), {"start_travel_mm": 19.5, **rig})
        self.ends: list[Ended] = []
        self.events: list[str] = []
        self.lies: list[dict[str, Any]] = []
        self.facts: list[tuple[str, dict[str, Any]]] = []
        self.device = Device(self.rig, seed, self, parse_all(lies))

    def ended(self, end: Ended) -> None:
        self.ends.append(end)

    def event(self, kind: str, text: str) -> None:
        self.events.append(kind)

    def truth(self, event: str, **fields: Any) -> None:
        self.facts.append((event, fields))
        if event == "lie":
            self.lies.append({"t_s": self.device.t_s, **fields})

    def forget_origin(self) -> None:
        self.events.append("origin")

    def restart_link(self) -> None:
        self.events.append("restart")

    def run(self, seconds: float, each: Callable[[], None] = lambda: None) -> "Bench":
        for _ in range(round(seconds / STEP_S)):
            self.device.step()
            each()
        return self

    def do(self, motion: Any, most_s: float = 20.0) -> Ended:
        """Steps until the motion has ended."""
        count = len(self.ends)
        self.device.start(motion)
        for _ in range(round(most_s / STEP_S)):
            self.device.step()
            if len(self.ends) > count:
                return self.ends[-1]
        raise AssertionError("the motion did not end")

    def fact(self, event: str) -> dict[str, Any]:
        return [fields for name, fields in self.facts if name == event][-1]

    def loop(self) -> ForceLoop:
        loop = self.device.capabilities().loop
        assert loop
        return loop


class Travel(unittest.TestCase):
    def test_move_stands_exactly_there_and_never_beyond(self) -> None:
        for goal, speed in ((19.7, 0.1), (15.0, 20.0), (19.5001, 5.0), (19.5, 1.0)):
            bench = Bench()
            furthest = [19.5]
            bench.run(0.01)
            bench.device.start(Move(1, WIDE, goal, speed))
            bench.run(2.5, lambda: furthest.append(bench.device.travel_mm))
            self.assertEqual((bench.ends[-1].reason, bench.device.travel_mm), ("target", goal))
            self.assertEqual(max(furthest, key=lambda x: abs(x - 19.5)), goal)
            self.assertFalse(bench.device.moving())

    def test_speed_and_deceleration_are_what_they_are_called(self) -> None:
        bench = Bench(start_travel_mm=5.0)
        speeds: list[float] = []
        last = [bench.device.travel_mm]

        def note() -> None:
            speeds.append((bench.device.travel_mm - last[0]) / STEP_S)
            last[0] = bench.device.travel_mm

        bench.device.start(Move(1, WIDE, 12.0, 10.0))
        bench.run(1.5, note)
        self.assertAlmostEqual(max(speeds), 10.0)
        hardest = max((a - b) / STEP_S for a, b in zip(speeds, speeds[1:]))
        self.assertLess(hardest, 100.0 * 1.02)

    def test_stop_after_its_reaction_within_its_way(self) -> None:
        bench = Bench(start_travel_mm=5.0)
        bench.device.start(Move(1, WIDE, 18.0, 10.0))
        bench.run(0.5)
        before = bench.device.travel_mm
        bench.device.stop()
        bench.run(0.5)
        way = bench.device.travel_mm - before
        self.assertAlmostEqual(way, 10 * 0.002 + 10 ** 2 / 200, delta=0.01)
        self.assertEqual(bench.ends[-1].reason, "stop")

    def test_soft_ends_hold_whatever_is_asked(self) -> None:
        bench = Bench(start_travel_mm=58.0, contact_travel_mm=70.0)
        no_window = Window(-math.inf, math.inf, -math.inf, math.inf, math.inf)
        bench.do(Move(1, no_window, 99.0, 20.0))
        self.assertEqual(bench.device.travel_mm, 60.0)

    def test_from_a_hold_into_a_motion(self) -> None:
        bench = Bench()
        self.assertEqual(bench.do(RampForce(1, WIDE, 0.5, 1.0)).reason, "target")
        self.assertEqual(bench.do(Move(2, WIDE, 19.0, 1.0)).reason, "target")
        self.assertEqual(bench.device.travel_mm, 19.0)


class ForceStops(unittest.TestCase):
    def test_reaction_and_overshoot_keep_what_caps_promise(self) -> None:
        for device_stop, poll_cycle_s in ((1, 0.05), (0, 0.05), (0, 0.3)):
            for k, speed, seed in ((1.0, 0.1, 1), (10.0, 0.5, 2), (40.0, 0.2, 3), (5.0, 2.0, 4)):
                bench = Bench(seed, device_stop=device_stop, poll_cycle_s=poll_cycle_s, stiffness_N_mm=k)
                can = bench.device.capabilities()
                end = bench.do(MoveToForce(1, WIDE, 0.5, speed, 22.0))
                fact = bench.fact("force_stop")
                with self.subTest(device_stop=device_stop, k=k, speed=speed):
                    self.assertEqual(end.reason, "target")
                    self.assertLessEqual(fact["reaction_s"], can.reaction_s)
                    way = speed * can.reaction_s + speed ** 2 / (2 * can.deceleration_mm_s2)
                    self.assertLessEqual(bench.device.peak_force_N, 0.5 + 50.0 * way + 0.003)

    def test_a_slow_approach_on_a_noisy_cell_is_not_late(self) -> None:
        bench = Bench(start_travel_mm=19.999, cell_noise_N=0.002)
        bench.do(MoveToForce(1, WIDE, 0.05, 0.005, 22.0), 5.0)
        fact = bench.fact("force_stop")
        self.assertTrue(fact["crossed_force_N"] is None or fact["reaction_s"] <= 0.01)

    def test_the_guard_is_never_passed(self) -> None:
        for speed in (0.5, 20.0):
            bench = Bench(contact_travel_mm=40.0)
            end = bench.do(MoveToForce(1, WIDE, 1.0, speed, 21.0))
            self.assertEqual((end.reason, bench.device.max_travel_mm), ("travel_limit", 21.0))

    def test_what_is_so_already_moves_nothing(self) -> None:
        bench = Bench().run(0.01)
        for motion, reason in ((MoveToForce(1, WIDE, 0.5, -1.0, 10.0), "target"),
                               (MoveToForce(2, WIDE, 0.5, 1.0, 19.0), "travel_limit")):
            self.assertEqual(bench.do(motion, 0.1).reason, reason)
        self.assertEqual(bench.device.travel_mm, 19.5)

    def test_unloading_to_a_force(self) -> None:
        bench = Bench()
        bench.do(MoveToForce(1, WIDE, 1.0, 0.5, 22.0))
        end = bench.do(MoveToForce(2, WIDE, 0.3, -0.5, 10.0))
        self.assertEqual(end.reason, "target")
        self.assertLessEqual(end.force_N or 0.0, 0.3)

    def test_a_force_limit_ends_any_motion(self) -> None:
        tight = Window(-0.2, 0.4, 0.0, 60.0, 20.0)
        for motion in (Move(1, tight, 22.0, 0.5), RampForce(1, tight, 0.8, 1.0)):
            bench = Bench()
            self.assertEqual(bench.do(motion).reason, "force_limit")
            self.assertLess(bench.device.peak_force_N, 0.45)

    def test_the_way_back_is_open_while_the_force_does_not_grow(self) -> None:
        bench = Bench()
        bench.do(MoveToForce(1, WIDE, 1.0, 0.5, 22.0))
        now = bench.device.shown_force_N() or 0.0
        back = Window(-0.2, now + 0.01, 0.0, 60.0, 20.0)
        self.assertEqual(bench.do(Move(2, back, 19.0, 1.0)).reason, "target")

    def test_overload_ends_a_motion_and_only_less_travel_leaves_it(self) -> None:
        bench = Bench(cell_nominal_N=2.0)
        wide = Window(-2.0, math.inf, 0.0, 60.0, 20.0)
        self.assertEqual(bench.do(Move(1, wide, 25.0, 1.0)).reason, "force_limit")
        self.assertIsNone(bench.ends[-1].force_N)
        self.assertTrue(bench.device.state().overload)
        self.assertIn("overload", bench.events)
        self.assertEqual(bench.do(Move(2, wide, 19.0, 1.0)).reason, "target")
        self.assertFalse(bench.device.state().overload)

    def test_an_old_order_to_brake_does_not_meet_the_next_motion(self) -> None:
        bench = Bench(device_stop=0, poll_reaction_s=0.5)
        bench.device.start(MoveToForce(1, WIDE, 0.01, 0.1, 22.0))
        while bench.device.force_N < 0.02:
            bench.run(0.01)
        bench.run(0.06)  # the watch has noticed it, and its order is not yet carried out
        bench.device.stop()
        bench.run(0.02)
        self.assertEqual(len(bench.ends), 1)
        self.assertEqual(bench.do(Move(2, WIDE, 19.0, 1.0)).reason, "target")


class Control(unittest.TestCase):
    def test_overshoot_and_ripple_keep_what_caps_promise(self) -> None:
        for k, rate, target, seed in ((0.2, 0.1, 0.5, 1), (5.0, 2.0, 1.0, 2), (50.0, 2.0, 2.0, 3),
                                      (50.0, 0.2, 1.0, 4), (1.0, 2.0, 0.3, 5)):
            bench = Bench(seed, stiffness_N_mm=k, cell_offset_N=0.0)
            loop, can = bench.loop(), bench.device.capabilities()
            with self.subTest(k=k, rate=rate):
                self.assertEqual(bench.do(RampForce(1, WIDE, target, rate), 60.0).reason, "target")
                way = (loop.force_approach_mm_s * can.reaction_s
                       + loop.force_approach_mm_s ** 2 / (2 * can.deceleration_mm_s2))
                first = loop.force_contact_N + 50.0 * way
                most = max(first, target + rate * loop.force_lag_s + loop.force_ripple_N)
                self.assertLessEqual(bench.device.peak_force_N, most + 0.003)
                worst = [0.0]
                bench.run(1.0, lambda: worst.append(abs(bench.device.force_N - target)))
                self.assertLessEqual(max(worst), loop.force_ripple_N)
                self.assertTrue(bench.device.state().holds_force and not bench.device.moving())

    def test_ramp_downwards(self) -> None:
        bench = Bench()
        bench.do(RampForce(1, WIDE, 1.0, 1.0))
        least = [9.0]
        bench.device.start(RampForce(2, WIDE, 0.4, 1.0))
        bench.run(1.5, lambda: least.append(bench.device.force_N))
        loop = bench.loop()
        self.assertEqual(bench.ends[-1].reason, "target")
        self.assertGreater(min(least), 0.4 - loop.force_lag_s - loop.force_ripple_N)

    def test_a_specimen_that_gives_way_is_followed(self) -> None:
        bench = Bench(creep_fraction=0.2, creep_time_s=2.0)
        bench.do(RampForce(1, WIDE, 1.0, 1.0))
        before, worst = bench.device.travel_mm, [0.0]
        bench.run(3.0, lambda: worst.append(abs(bench.device.force_N - 1.0)))
        self.assertLess(max(worst), bench.loop().force_ripple_N)
        self.assertGreater(bench.device.travel_mm, before + 0.01)

    def test_at_a_limit_of_travel_the_hold_ends_and_stands(self) -> None:
        bench = Bench(creep_fraction=0.5, creep_time_s=1.0)
        bench.do(RampForce(1, Window(-1, 20, 0, 22.0, 1), 0.6, 1.0))
        bench.device.arm(Window(-1.0, 20.0, 0.0, bench.device.travel_mm + 0.008, 1.0))
        bench.run(2.0)
        self.assertIn("travel_limit", bench.events)
        self.assertFalse(bench.device.state().holds_force)

    def test_without_specimen_the_approach_ends_at_the_limit_of_travel(self) -> None:
        bench = Bench(contact_travel_mm=30.0)
        end = bench.do(RampForce(1, Window(-1, 1, 0, 20, 1), 0.5, 1.0))
        self.assertEqual((end.reason, bench.device.max_travel_mm), ("travel_limit", 20.0))

    def test_the_approach_is_slow(self) -> None:
        bench = Bench()
        bench.device.start(RampForce(1, WIDE, 0.5, 1.0))
        bench.run(0.5)
        self.assertLess(bench.device.travel_mm, 19.5 + 0.5 * 0.5)

    def test_hold_goes_to_its_force_and_new_limits_do_not_end_it(self) -> None:
        bench = Bench()
        bench.do(MoveToForce(1, WIDE, 0.5, 0.2, 22.0))
        bench.device.hold_force(HoldForce(WIDE, 0.8))
        bench.run(0.1)
        self.assertTrue(bench.device.moving())
        bench.run(1.0)
        self.assertFalse(bench.device.moving())
        bench.device.arm(Window(-0.1, 0.5, 0.0, 60.0, 1.0))
        bench.run(0.5)
        self.assertTrue(bench.device.state().holds_force)
        self.assertAlmostEqual(bench.device.force_N, 0.8, delta=0.006)

    def test_stop_ends_force_control(self) -> None:
        bench = Bench()
        bench.do(RampForce(1, WIDE, 0.5, 1.0))
        bench.device.stop()
        self.assertTrue(bench.device.state().moving)
        bench.run(0.1)
        self.assertFalse(bench.device.state().holds_force or bench.device.state().moving)


class Cell(unittest.TestCase):
    def test_zero_takes_offset_and_drift_away_and_moves_the_travel(self) -> None:
        bench = Bench(cell_offset_N=0.3, cell_drift_N_s=0.01).run(1.0)
        self.assertAlmostEqual(bench.device.shown_force_N() or 0, 0.31, delta=0.005)
        bench.device.zero(True, True)
        self.assertAlmostEqual(bench.device.shown_force_N() or 0, 0.0, delta=0.003)
        self.assertEqual(bench.device.shown_travel_mm(), 0.0)
        can = bench.device.capabilities()
        self.assertEqual((can.travel_min_mm, can.travel_max_mm), (-19.5, 40.5))
        bench.run(1.0)
        self.assertAlmostEqual(bench.device.shown_force_N() or 0, 0.01, delta=0.005)

    def test_zero_is_for_standing_machines(self) -> None:
        bench = Bench()
        bench.device.start(Move(1, WIDE, 19.0, 0.1))
        bench.run(0.1)
        with self.assertRaises(Refused):
            bench.device.zero(True, False)

    def test_a_tared_threshold_is_one_of_shown_force(self) -> None:
        bench = Bench(cell_offset_N=0.3).run(0.2)
        bench.device.zero(True, False)
        bench.do(MoveToForce(1, WIDE, 0.5, 0.1, 22.0))
        self.assertAlmostEqual(bench.device.force_N, 0.5, delta=0.01)


class Truth(unittest.TestCase):
    def test_same_orders_at_same_times_give_the_same_life(self) -> None:
        def life(seed: int) -> tuple[object, ...]:
            bench = Bench(seed, creep_fraction=0.1)
            bench.do(RampForce(1, WIDE, 0.5, 1.0))
            bench.run(0.5)
            return bench.device.step_count, bench.device.force_N, bench.device.state(), bench.facts

        self.assertEqual(life(7), life(7))
        self.assertNotEqual(life(7), life(8))

    def test_a_healthy_rig_declares_no_more_than_it_keeps(self) -> None:
        self.assertEqual(list(dishonest(Rig())), [])
        for key, value in (("deceleration_mm_s2", 20), ("device_stop", 0), ("cell_noise_N", 0.01)):
            self.assertEqual(list(dishonest(with_values(Rig(), {key: value}))), [])

    def test_a_lie_is_found(self) -> None:
        for key, value in (("declared_reaction_s", 0.001), ("declared_deceleration_mm_s2", 500),
                           ("declared_force_ripple_N", 0), ("declared_force_max_N", 50)):
            self.assertEqual(len(list(dishonest(with_values(Rig(), {key: value})))), 1)


if __name__ == "__main__":
    unittest.main()
