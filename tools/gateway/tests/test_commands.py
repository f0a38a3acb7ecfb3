# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from dataclasses import replace

from gateway.backend import Ended, HoldForce, Motion, Refused
from gateway.tests.support import CAPABILITIES, LIMITS, STANDING, Desk, sample


class Commands(unittest.TestCase):
    def test_numbers_grow(self) -> None:
        desk = Desk().armed()
        codes = [desk.code(f"#{n} STATUS") for n in (5, 5, 4, 6)]
        self.assertEqual(codes, ["OK", "bad_value", "bad_value", "OK"])

    def test_a_motion_is_done_once(self) -> None:
        desk = Desk().armed()
        self.assertEqual(desk.code("#2 MOVE travel_mm=1 speed_mm_s=1"), "OK")
        (done,) = desk.end("target")
        self.assertEqual((done.word, done.command, done.fields["reason"]), ("DONE", 2, "target"))
        self.assertEqual(desk.end("target"), [])

    def test_done_never_comes_before_ok(self) -> None:
        desk = Desk().armed()
        desk.blocked = True
        desk.say("#2 MOVE travel_mm=1 speed_mm_s=1")
        desk.release(1)  # refresh
        answer = desk.waiting.pop()
        answers: list[object] = []
        desk.machine.start = lambda motion: answers.append(desk.session.ended(_ended(motion)))  # type: ignore
        answer()
        self.assertEqual([line.word for line in desk.said()], ["OK", "DONE"])

    def test_pending_samples_come_before_done(self) -> None:
        desk = Desk().armed()
        desk.say("#2 RATE hz=50", "#3 MOVE travel_mm=1 speed_mm_s=1")
        desk.session.samples([sample(moving=True)] * 3)
        self.assertEqual([line.word for line in desk.end("target")], ["S", "DONE"])

    def test_unknown_force_and_travel_are_left_out(self) -> None:
        desk = Desk().armed()
        desk.machine.now = replace(STANDING, force_N=None, overload=True)
        self.assertNotIn("force_N", desk.one("STOP").fields)

    def test_second_motion_limits_and_zero_are_busy(self) -> None:
        desk = Desk().armed()
        desk.say("#2 MOVE travel_mm=1 speed_mm_s=1")
        for number, text in enumerate(("MOVE travel_mm=2 speed_mm_s=1", LIMITS, "ZERO force=1",
                                       "HOLD mode=force force_N=1"), 3):
            self.assertEqual(desk.code(f"#{number} {text}"), "busy")
        self.assertEqual(desk.code("#8 RATE hz=10"), "OK")

    def test_a_motion_that_others_commanded_is_busy_too(self) -> None:
        desk = Desk().armed()
        desk.machine.now = replace(STANDING, moving=True)
        self.assertEqual(desk.code("#2 MOVE travel_mm=1 speed_mm_s=1"), "busy")

    def test_limits_are_replaced_while_a_force_is_held(self) -> None:
        desk = Desk().armed()
        desk.machine.now = replace(STANDING, holds_force=True, force_N=1.0)
        self.assertEqual(desk.code(f"#2 {LIMITS}"), "OK")
        self.assertEqual(desk.code("#3 ZERO force=1"), "busy")

    def test_zero_carries_the_new_origin(self) -> None:
        desk = Desk().armed()
        self.assertEqual(desk.one("#2 ZERO force=1 travel=0").fields["origin"], "o1")
        self.assertIn(("zero", True, False), desk.machine.calls)

    def test_the_machine_may_refuse(self) -> None:
        desk = Desk().armed()
        desk.machine.refuses = Refused("not_ready", "shield open")
        self.assertEqual(desk.code("#2 MOVE travel_mm=1 speed_mm_s=1"), "not_ready")
        desk.machine.refuses = None
        self.assertEqual(desk.code("#3 MOVE travel_mm=1 speed_mm_s=1"), "OK")

    def test_a_crash_of_the_back_end_is_internal_and_stops(self) -> None:
        desk = Desk().armed()
        desk.machine.refuses = ZeroDivisionError("oops")
        line = desk.one("#2 MOVE travel_mm=1 speed_mm_s=1")
        self.assertEqual((line.fields["code"], desk.machine.stops()), ("internal", 1))

    def test_commands_wait_for_each_other(self) -> None:
        desk = Desk().armed()
        desk.blocked = True
        desk.say("#2 STATUS", "#3 RATE hz=5", "#4 STATUS")
        desk.release()
        self.assertEqual([line.command for line in desk.said()], [2, 3, 4])

    def test_what_waits_is_bounded(self) -> None:
        desk = Desk().armed()
        desk.blocked = True
        answers = desk.say(*[f"#{n} STATUS" for n in range(2, 200)])
        self.assertEqual({line.fields["code"] for line in answers}, {"busy"})


def _ended(motion: Motion) -> Ended:
    return Ended(motion.token, "target")


class Malformed(unittest.TestCase):
    def test_a_bad_command_is_answered_and_not_obeyed(self) -> None:
        desk = Desk().armed()
        for text in ("#2 MOVE travel_mm=1,5 speed_mm_s=1", "#2 MOVE travel_mm=nan speed_mm_s=1",
                     "#2 MOVE travel_mm=1 travel_mm=1 speed_mm_s=1", "#2 MOVE travel_mm=1\tspeed_mm_s=1",
                     "#2 MOVE travel_mm=1 speed_mm_s"):
            self.assertEqual(desk.code(text), "syntax")
        self.assertEqual(desk.machine.calls, [])

    def test_lacking_field_and_unknown_command(self) -> None:
        desk = Desk().armed()
        self.assertEqual(desk.code("#2 MOVE travel_mm=1"), "syntax")
        self.assertEqual(desk.code("#3 DANCE"), "unknown_command")

    def test_bad_lines_are_no_life_sign(self) -> None:
        desk = Desk().armed()
        kinds = []
        for _ in range(12):
            desk.say("HB x=1 x=2")
            desk.session.received(b"#9 STATUS x=\x01")
            kinds += [x.fields.get("kind") for x in desk.wait(0.1)]
        self.assertIn("watchdog", kinds)

    def test_noise_is_not_answered_by_noise(self) -> None:
        desk = Desk()
        self.assertLessEqual(len(desk.say(*["rubbish =="] * 1000)), 20)

    def test_a_stop_in_a_bad_line_does_not_count(self) -> None:
        desk = Desk().armed()
        self.assertEqual(desk.one("STOP x=1 x=1").word, "EVENT")
        self.assertEqual(desk.machine.stops(), 0)


class Judging(unittest.TestCase):
    """Section 4: limits, and the way back from beyond a limit."""

    def check(self, text: str, expected: str, **state: object) -> Desk:
        desk = Desk().armed()
        desk.machine.now = replace(STANDING, **state)
        self.assertEqual(desk.code(f"#2 {text}"), expected)
        return desk

    def test_targets_and_speeds(self) -> None:
        for text, code in (
            ("MOVE travel_mm=6 speed_mm_s=1", "limits"), ("MOVE travel_mm=1 speed_mm_s=2", "limits"),
            ("MOVE travel_mm=1 speed_mm_s=0", "bad_value"), ("MOVE travel_mm=1 speed_mm_s=-1", "bad_value"),
            ("MOVE travel_mm=1 speed_mm_s=0.0001", "machine_limits"),
            ("MOVEF force_N=2 speed_mm_s=1 guard_mm=5", "limits"),
            ("MOVEF force_N=1 speed_mm_s=1 guard_mm=6", "limits"),
            ("MOVEF force_N=1 speed_mm_s=0 guard_mm=5", "bad_value"),
            ("MOVEF force_N=-0.1 speed_mm_s=-1 guard_mm=-5", "OK"),
            ("RAMPF force_N=1 rate_N_s=0", "bad_value"), ("RAMPF force_N=1 rate_N_s=3", "machine_limits"),
            ("RAMPF force_N=2 rate_N_s=1", "limits"), ("RAMPF force_N=1 rate_N_s=1", "OK"),
            ("HOLD mode=force force_N=1", "no_contact"), ("HOLD mode=air", "bad_value"),
            ("RATE hz=501", "machine_limits"), ("RATE hz=-1", "bad_value"),
            ("ZERO", "bad_value"), ("ZERO force=2", "syntax"),
        ):
            with self.subTest(text=text):
                self.check(text, code)

    def test_limits_are_judged(self) -> None:
        good: dict[str, float] = {"force_min_N": -1, "force_max_N": 1, "travel_min_mm": -1,
                                  "travel_max_mm": 1, "speed_max_mm_s": 1}
        changes: tuple[tuple[dict[str, float], str], ...] = (
            ({}, "OK"), ({"force_max_N": 21}, "machine_limits"),
            ({"force_min_N": -21}, "machine_limits"), ({"force_max_N": -1}, "bad_value"),
            ({"travel_max_mm": 31}, "machine_limits"), ({"travel_min_mm": 1}, "bad_value"),
            ({"speed_max_mm_s": 0}, "bad_value"), ({"speed_max_mm_s": 11}, "machine_limits"))
        for change, code in changes:
            fields = " ".join(f"{k}={v}" for k, v in {**good, **change}.items())
            with self.subTest(change=change):
                self.check(f"LIMITS {fields}", code)

    def test_what_the_machine_cannot(self) -> None:
        desk = Desk().armed()
        desk.machine.can = replace(CAPABILITIES, force_hold=False, zero_force=False, loop=None)
        self.assertEqual(desk.code("#2 RAMPF force_N=1 rate_N_s=1"), "unsupported")
        self.assertEqual(desk.code("#3 ZERO force=1"), "unsupported")
        desk.machine.can = replace(CAPABILITIES, motion=False)
        self.assertEqual(desk.code("#4 MOVE travel_mm=1 speed_mm_s=1"), "unsupported")

    def test_not_ready(self) -> None:
        self.check("MOVE travel_mm=1 speed_mm_s=1", "not_ready", not_ready="E-stop")

    def test_the_way_back_from_too_much_force(self) -> None:
        self.check("MOVE travel_mm=1 speed_mm_s=1", "limits", force_N=1.6)
        desk = self.check("MOVE travel_mm=-1 speed_mm_s=1", "OK", force_N=1.6)
        window = desk.machine.motion().window
        self.assertAlmostEqual(window.force_max_N, 1.6 + 2 * 0.002)
        self.assertEqual(window.force_min_N, -0.2)
        self.check("MOVEF force_N=1 speed_mm_s=-1 guard_mm=-5", "OK", force_N=1.6)
        self.check("MOVEF force_N=1 speed_mm_s=1 guard_mm=5", "limits", force_N=1.6)
        self.check("RAMPF force_N=1 rate_N_s=1", "OK", force_N=1.6)

    def test_the_way_back_from_too_little_force(self) -> None:
        self.check("MOVE travel_mm=-1 speed_mm_s=1", "limits", force_N=-0.3)
        desk = self.check("MOVE travel_mm=1 speed_mm_s=1", "OK", force_N=-0.3)
        self.assertAlmostEqual(desk.machine.motion().window.force_min_N, -0.304)

    def test_in_overload_less_travel_is_the_way_back(self) -> None:
        overload = {"force_N": None, "overload": True}
        self.check("MOVE travel_mm=-1 speed_mm_s=1", "OK", **overload)
        self.check("MOVE travel_mm=1 speed_mm_s=1", "overload", **overload)
        self.check("RAMPF force_N=1 rate_N_s=1", "overload", **overload)
        self.check("ZERO force=1", "overload", **overload)
        self.check("ZERO travel=1", "OK", **overload)

    def test_the_way_back_from_outside_the_travel(self) -> None:
        desk = self.check("MOVE travel_mm=5 speed_mm_s=1", "OK", travel_mm=7.0)
        self.assertEqual(desk.machine.motion().window.travel_max_mm, 7.0)
        self.check("MOVEF force_N=1 speed_mm_s=1 guard_mm=5", "limits", travel_mm=7.0)
        self.check("MOVEF force_N=0 speed_mm_s=-1 guard_mm=-5", "limits", travel_mm=-7.0)

    def test_hold_of_a_force(self) -> None:
        desk = self.check("HOLD mode=force force_N=1", "OK", force_N=0.5)
        self.assertIsInstance(desk.machine.calls[-1], HoldForce)
        self.check("HOLD mode=force force_N=9", "limits", force_N=0.5)

    def test_limits_that_zero_moved_beyond_the_machine(self) -> None:
        desk = Desk().armed()
        desk.machine.can = replace(CAPABILITIES, travel_max_mm=3.0)
        self.assertEqual(desk.code("#2 MOVE travel_mm=4 speed_mm_s=1"), "machine_limits")


if __name__ == "__main__":
    unittest.main()
