# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import random
from typing import Callable

from gateway.backend import Ended, HoldForce, Move, MoveToForce, RampForce, Refused, Sample
from gateway.simulated.delivery import Delivery
from gateway.simulated.lie_options import LIES, BadLie, describe, overview, parse, parse_all
from gateway.simulated.rig import Rig
from gateway.tests.test_device import WIDE, Bench


def touch(force_N: float = 0.5, speed_mm_s: float = 0.5, guard_mm: float = 20.4) -> MoveToForce:
    return MoveToForce(1, WIDE, force_N, speed_mm_s, guard_mm)


class Options(unittest.TestCase):
    def refused(self, text: str) -> str:
        with self.assertRaises(BadLie) as raised:
            parse(text)
        return str(raised.exception)

    def test_what_is_wrong_is_said_with_what_is_allowed(self) -> None:
        for text, why in (("crep", "did you mean creep\\? There are: force_frozen, .*caps_changed"),
                          ("", "There are: force_frozen"),
                          ("creep", "creep needs speed_um_s"),
                          ("creep,um_s=5", "um_s: creep takes speed_um_s, stop_ends, at_s"),
                          ("force_drift,rate_N_s=x", "rate_N_s: expected a number, found 'x'"),
                          ("force_drift,rate_N_s=nan", "expected a number"),
                          ("force_drift,rate_N_s", "expected key=value"),
                          ("estop,for_s=-1", "outside 0 to inf"),
                          ("estop,for_s=1,for_s=2", "for_s comes twice"),
                          ("estop,motion=1.5", "whole number"),
                          ("estop,motion=1,at_s=1", "at_s or motion, not both"),
                          ("estop,after_s=1", "after_s needs motion"),
                          ("estop,times=2", "estop takes at_s")):
            with self.subTest(text=text):
                self.assertRegex(self.refused(text), why)

    def test_each_lie_is_described(self) -> None:
        for lines in (list(overview()), list(describe())):
            for name in LIES:
                self.assertTrue(any(line.split()[0] == name for line in lines), name)
        self.assertEqual(len(list(overview())), len(LIES))


class Begins(unittest.TestCase):
    def lie(self, bench: Bench) -> list[tuple[float, bool]]:
        return [(round(fields["t_s"], 3), fields["on"]) for fields in bench.lies]

    def test_at_a_time_for_a_while(self) -> None:
        bench = Bench(1, "force_reversed,at_s=0.5,for_s=0.25").run(1.0)
        self.assertEqual(self.lie(bench), [(0.5, True), (0.75, False)])

    def test_in_a_motion(self) -> None:
        bench = Bench(1, "force_frozen,motion=2,after_s=0.1").run(0.3)
        bench.do(Move(1, WIDE, 19.0, 5.0))
        self.assertEqual(bench.lies, [])
        begun_s = bench.device.t_s
        bench.do(Move(2, WIDE, 15.0, 5.0))
        self.assertAlmostEqual(bench.lies[0]["t_s"], begun_s + 0.1, delta=0.001)

    def test_several_at_once_each_in_its_time(self) -> None:
        bench = Bench(1, "force_drift,rate_N_s=1,at_s=1", "force_reversed,at_s=2", cell_noise_N=0).run(1.5)
        self.assertAlmostEqual(bench.device.shown_force_N() or 0, 0.5, delta=0.003)
        bench.run(1.0)
        self.assertAlmostEqual(bench.device.shown_force_N() or 0, -1.5, delta=0.003)

    def test_what_had_no_occasion_is_known(self) -> None:
        lies = parse_all(["estop,motion=3", "clock_frozen"])
        bench = Bench()
        lies.follow(1.0, 0, 0.0, bench.device)
        self.assertEqual(lies.untold(), ["estop"])


class Cell(unittest.TestCase):
    def test_a_frozen_force_is_the_same_to_the_last_digit_and_stops_nothing(self) -> None:
        bench = Bench(1, "force_frozen,motion=1,after_s=0.3")
        seen: set[float | None] = set()
        self.assertEqual(bench.do(touch()).reason, "travel_limit")
        bench.run(0.2, lambda: seen.add(bench.device.shown_force_N()))
        self.assertEqual(len(seen), 1)
        self.assertGreater(bench.device.force_N, 2.0)

    def test_a_reversed_force_is_tension(self) -> None:
        bench = Bench(1, "force_reversed", cell_offset_N=0.3).run(0.2)
        bench.device.zero(True, False)
        bench.do(touch(guard_mm=20.1))
        self.assertAlmostEqual(bench.device.shown_force_N() or 0, -bench.device.force_N, delta=0.003)
        self.assertGreater(bench.device.force_N, 0.5)

    def test_a_held_force_scatters_and_does_not_rise(self) -> None:
        bench = Bench(1, "force_held,motion=1,after_s=0.3")
        seen: set[float | None] = set()
        self.assertEqual(bench.do(touch()).reason, "travel_limit")
        bench.run(0.2, lambda: seen.add(bench.device.shown_force_N()))
        self.assertGreater(len(seen), 3)
        self.assertLess(max(f or 0 for f in seen), 0.2)
        self.assertGreater(bench.device.force_N, 2.0)

    def test_a_gain(self) -> None:
        bench = Bench(1, "force_gain,factor=0.5").run(0.2)
        bench.do(touch(guard_mm=20.1))
        self.assertAlmostEqual(bench.device.shown_force_N() or 0, 0.5 * bench.device.force_N, delta=0.003)

    def test_drift(self) -> None:
        bench = Bench(1, "force_drift,rate_N_s=-0.1,at_s=1").run(3.0)
        self.assertAlmostEqual(bench.device.shown_force_N() or 0, -0.2, delta=0.003)

    def test_scatter(self) -> None:
        bench = Bench(1, "force_scatter,factor=20")
        seen: list[float] = []
        bench.run(0.5, lambda: seen.append(bench.device.shown_force_N() or 0))
        self.assertGreater(max(seen), 0.02)

    def test_a_lost_tare_is_told_or_not(self) -> None:
        for told in (0, 1):
            bench = Bench(1, f"tare_lost,at_s=1,origin_changes={told}", cell_offset_N=0.3).run(0.5)
            bench.device.zero(True, False)
            bench.run(0.4)
            self.assertAlmostEqual(bench.device.shown_force_N() or 0, 0.0, delta=0.003)
            bench.run(0.5)
            self.assertAlmostEqual(bench.device.shown_force_N() or 0, 0.3, delta=0.003)
            self.assertEqual(bench.events, ["origin"] * told)

    def test_a_lost_tare_with_a_restart(self) -> None:
        bench = Bench(1, "tare_lost,restart=1").run(0.1)
        self.assertEqual(bench.events, ["restart"])

    def test_clocks(self) -> None:
        quick = Bench(1, "clock_rate,factor=2,at_s=0.5").run(2.0)
        self.assertAlmostEqual(quick.device.sample().t_s or 0, 1003.5, delta=0.002)
        frozen = Bench(1, "clock_frozen,at_s=0.5").run(2.0)
        self.assertAlmostEqual(frozen.device.sample().t_s or 0, 1000.5, delta=0.001)
        jumped = Bench(1, "clock_jump,jump_s=-30,at_s=0.5").run(2.0)
        self.assertAlmostEqual(jumped.device.state().device_s or 0, 972.0, delta=0.001)


class Drive(unittest.TestCase):
    def test_a_stalled_drive_turns_and_goes_nowhere(self) -> None:
        bench = Bench(1, "drive_stalled,motion=1,after_s=0.5")
        bench.device.start(Move(1, WIDE, 15.0, 1.0))
        bench.run(0.5)
        before = bench.device.travel_mm
        bench.run(20.0)
        self.assertAlmostEqual(bench.device.travel_mm, before, delta=0.001)
        self.assertTrue(bench.device.moving())
        self.assertFalse(bench.device.turning())
        self.assertEqual(bench.ends, [])

    def test_a_reversed_drive_goes_the_other_way_to_its_end_and_stops_when_told(self) -> None:
        bench = Bench(1, "drive_reversed")
        bench.device.start(Move(1, WIDE, 25.0, 5.0))
        bench.run(1.0)
        self.assertLess(bench.device.travel_mm, 15.0)
        bench.run(5.0)
        self.assertEqual(bench.device.travel_mm, 0.0)
        bench.device.stop()
        bench.run(0.2)
        self.assertEqual(bench.ends[-1].reason, "stop")

    def test_creep_begins_with_done_and_stop_ends_it(self) -> None:
        for stop_ends in (0, 1):
            bench = Bench(1, f"creep,speed_um_s=5,stop_ends={stop_ends}").run(1.0)
            self.assertEqual(bench.device.travel_mm, 19.5)
            bench.do(Move(1, WIDE, 19.0, 1.0))
            bench.run(2.0)
            self.assertAlmostEqual(bench.device.travel_mm, 19.01, delta=0.0005)
            self.assertFalse(bench.device.moving())
            self.assertTrue(bench.device.turning())
            bench.device.stop()
            bench.run(2.0)
            self.assertAlmostEqual(bench.device.travel_mm, 19.01 + 0.01 * (1 - stop_ends), delta=0.0005)


class Ends(unittest.TestCase):
    def test_done_early_and_the_axis_goes_on(self) -> None:
        for shown in (0, 1):
            bench = Bench(1, f"done_early,delay_s=0.2,shown={shown}")
            end = bench.do(Move(1, WIDE, 18.5, 1.0))
            self.assertEqual(end.reason, "target")
            self.assertAlmostEqual(end.travel_mm or 0, 19.3, delta=0.02)
            self.assertEqual(bench.device.sample().moving, bool(shown))
            bench.run(2.0)
            self.assertEqual(bench.device.travel_mm, 18.5)
            self.assertEqual(len(bench.ends), 1)

    def test_after_done_early_the_next_motion_is_taken(self) -> None:
        bench = Bench(1, "done_early,times=1")
        bench.do(Move(1, WIDE, 18.5, 1.0))
        self.assertEqual(bench.do(Move(2, WIDE, 19.2, 1.0)).token, 2)
        self.assertEqual(bench.device.travel_mm, 19.2)

    def test_a_motion_that_does_not_take_place_claims_its_target(self) -> None:
        for claims in (0, 1):
            bench = Bench(1, f"done_unmoved,times=3,claims={claims}")
            force = bench.do(touch(1.0))
            self.assertEqual(force.reason, "target")
            self.assertAlmostEqual(force.force_N or 0, float(claims), delta=0.003)
            self.assertEqual(force.travel_mm, 19.5)
            travel = bench.do(Move(2, WIDE, 18.0, 1.0))
            self.assertEqual(travel.travel_mm, 18.0 if claims else 19.5)
            self.assertEqual(bench.do(RampForce(3, WIDE, 0.5, 1.0)).reason, "target")
            self.assertEqual((bench.device.travel_mm, bench.device.motions), (19.5, 0))
            self.assertEqual(bench.do(Move(4, WIDE, 18.0, 1.0)).reason, "target")
            self.assertEqual(bench.device.travel_mm, 18.0)

    def test_stop_ends_a_motion_that_does_not_take_place(self) -> None:
        bench = Bench(1, "done_unmoved")
        bench.device.start(Move(1, WIDE, 18.0, 1.0))
        bench.run(0.1)
        bench.device.stop()
        bench.run(1.0)
        self.assertEqual([end.reason for end in bench.ends], ["stop"])

    def test_an_order_is_obeyed_late_also_after_a_stop(self) -> None:
        for stop in (False, True):
            bench = Bench(1, "order_late,delay_s=1,times=1")
            bench.device.start(Move(1, WIDE, 19.0, 1.0))
            bench.run(0.5)
            self.assertFalse(bench.device.moving())
            if stop:
                bench.device.stop()
                bench.run(0.1)
                self.assertEqual(bench.ends[-1].reason, "stop")
                self.assertFalse(bench.device.state().moving)
            bench.run(2.0)
            self.assertEqual(bench.device.travel_mm, 19.0)
            self.assertEqual([end.reason for end in bench.ends], ["stop" if stop else "target"])

    def test_a_late_order_waits_for_the_motion_that_came_after_the_stop(self) -> None:
        bench = Bench(1, "order_late,delay_s=0.5,times=1")
        bench.device.start(Move(1, WIDE, 19.9, 1.0))
        bench.device.stop()
        bench.run(0.1)
        bench.do(Move(2, WIDE, 18.5, 1.0))
        self.assertEqual((bench.ends[-1].token, bench.device.travel_mm), (2, 18.5))
        bench.run(3.0)
        self.assertEqual((len(bench.ends), bench.device.travel_mm), (2, 19.9))

    def test_estop_held_and_pulsed(self) -> None:
        for held_s in (0.05, 1.0):
            bench = Bench(1, f"estop,motion=1,after_s=0.3,for_s={held_s}")
            end = bench.do(Move(1, WIDE, 15.0, 1.0))
            self.assertEqual((end.reason, end.text, bench.events), ("fault", "E-stop", ["estop"]))
            bench.run(0.1)
            self.assertEqual(bench.device.state().not_ready, "E-stop" if held_s == 1.0 else "")
            if held_s == 1.0:
                with self.assertRaises(Refused):
                    bench.device.start(Move(2, WIDE, 15.0, 1.0))
                bench.run(1.0)
            self.assertEqual(bench.do(Move(3, WIDE, 19.0, 1.0)).reason, "target")

    def test_estop_ends_what_was_accepted_and_had_not_begun(self) -> None:
        bench = Bench(1, "estop,motion=1,after_s=0.001")
        self.assertEqual(bench.do(Move(1, WIDE, 15.0, 1.0)).reason, "fault")
        bench.run(1.0)
        self.assertEqual(bench.device.travel_mm, 19.5)

    def test_stop_late_and_ignored(self) -> None:
        for lie, reason, travel_mm in (("stop_late,delay_s=0.5", "stop", 19.0), ("stop_ignored", "target", 18.5)):
            bench = Bench(1, lie)
            bench.device.start(Move(1, WIDE, 18.5, 1.0))
            bench.run(0.01)
            bench.device.stop()
            bench.run(0.2)
            self.assertTrue(bench.device.state().moving)
            bench.run(2.0)
            self.assertEqual(bench.ends[-1].reason, reason)
            self.assertAlmostEqual(bench.device.travel_mm, travel_mm, delta=0.02)

    def test_caps_changed(self) -> None:
        bench = Bench(1, "caps_changed,force_max_N=5,at_s=0.5")
        self.assertEqual(bench.device.capabilities().force_max_N, 20.0)
        bench.run(1.0)
        self.assertEqual(bench.device.capabilities().force_max_N, 5.0)
        self.assertEqual(bench.events, ["restart"])
        half = Bench(1, "caps_changed").run(0.01)
        self.assertEqual(half.device.capabilities().speed_max_mm_s, 10.0)

    def test_stopped_is_withheld_and_nothing_else(self) -> None:
        lies = parse_all(["stop_unconfirmed"])
        self.assertFalse(lies.withholds(b"STOPPED stops=1\n"))
        lies.follow(0.0, 0, 0.0, Bench().device)
        self.assertTrue(lies.withholds(b"STOPPED stops=1\n"))
        self.assertFalse(lies.withholds(b"DONE #1 reason=stop\n"))


class TwoAtATime(unittest.TestCase):
    """Whatever lies are combined, the machine stays within its ends and reports each end once."""

    _VALUES = {"rate_N_s": 0.5, "factor": 10, "jump_s": 5, "delay_s": 0.3, "period_s": 0.5, "speed_um_s": 50}

    def lie(self, rng: random.Random) -> str:
        name = rng.choice(list(LIES))
        parameters = LIES[name].parameters
        texts = [name] + [f"{key}={value}" for key, value in self._VALUES.items() if key in parameters]
        when = rng.choice(["at_s=0", f"at_s={rng.uniform(0, 3)}", f"motion={rng.randint(1, 3)},after_s=0.1"])
        return ",".join([*texts, when] + ([f"for_s={rng.uniform(0, 1)}"] if rng.random() < 0.5 else []))

    def act(self, rng: random.Random, bench: Bench, token: int) -> None:
        device = bench.device
        actions: list[Callable[[], None]] = [
            device.stop,
            lambda: device.zero(True, False),
            lambda: device.start(Move(token, WIDE, rng.uniform(15, 21), 2.0)),
            lambda: device.start(touch(rng.uniform(-0.5, 1), rng.choice([-1, 1]))),
            lambda: device.start(RampForce(token, WIDE, 0.4, 1.0)),
            lambda: device.hold_force(HoldForce(WIDE, 0.3))]
        try:
            rng.choice(actions)()
        except Refused:
            pass

    def test_a_hundred_lives(self) -> None:
        for seed in range(100):
            rng = random.Random(seed)
            lies = [self.lie(rng), self.lie(rng)]
            with self.subTest(seed=seed, lies=lies):
                bench = Bench(seed, *lies)
                for token in range(10, 20):
                    self.act(rng, bench, token)
                    bench.run(rng.choice([0.001, 0.1, 0.5]))
                    self.assertTrue(0.0 <= bench.device.travel_mm <= 60.0)
                tokens = [end.token for end in bench.ends if end.token >= 10]
                self.assertEqual(len(tokens), len(set(tokens)))


class Samples(unittest.TestCase):
    def delivery(self, *texts: str) -> Delivery:
        lies = parse_all(texts)
        lies.follow(0.0, 0, 0.0, Bench().device)
        return Delivery(Rig(), lies)

    def times(self, delivery: Delivery, until_s: float) -> list[float | str | None]:
        return [item.t_s if isinstance(item, Sample) else item.reason for item in delivery.take(until_s)]

    def test_late_samples_do_not_hold_up_done(self) -> None:
        delivery = self.delivery("samples_late,delay_s=0.5")
        delivery.put(1.0, Sample(1.0, None, None))
        delivery.put(1.1, Ended(1, "target"))
        self.assertEqual(self.times(delivery, 1.2), ["target"])
        self.assertEqual(self.times(delivery, 1.6), [1.0])

    def test_bursts(self) -> None:
        delivery = self.delivery("samples_burst,period_s=2")
        for t_s in (0.5, 1.0, 2.5):
            delivery.put(t_s, Sample(t_s, None, None))
        self.assertEqual(self.times(delivery, 1.9), [])
        self.assertEqual(self.times(delivery, 2.1), [0.5, 1.0])


if __name__ == "__main__":
    unittest.main()
