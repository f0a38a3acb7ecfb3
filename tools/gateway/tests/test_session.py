# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from dataclasses import replace

from gateway.backend import STATED
from gateway.tests.support import LIMITS, STANDING, Desk, sample


class Opening(unittest.TestCase):
    def test_hello_is_answered_with_hello_and_caps(self) -> None:
        desk = Desk()
        hello, caps = desk.say("HELLO proto=1 revision=2 side=host maker=lcrig")
        self.assertEqual((hello.word, caps.word), ("HELLO", "CAPS"))
        self.assertEqual(hello.fields["origin"], "o0")
        self.assertEqual(hello.fields["simulated"], "1")
        self.assertEqual(caps.real("force_lag_s"), 0.02)
        self.assertEqual([caps.real(key) for key in STATED], [1.0, 0.1, 0.5, 0.02, 3.0])

    def test_what_a_back_end_does_not_know_is_not_sent(self) -> None:
        desk = Desk()
        desk.machine.can = replace(desk.machine.can, filter_s=None, play_um=None)
        _, caps = desk.say("HELLO proto=1")
        self.assertEqual([key for key in STATED if key in caps.fields], list(STATED[:3]))

    def test_revision_2_states_the_force_loop_but_no_steps(self) -> None:
        hello, caps = Desk(revision=2).say("HELLO proto=1 revision=3")
        self.assertEqual(hello.fields["revision"], "2")
        self.assertEqual(caps.real("force_lag_s"), 0.02)
        self.assertEqual([key for key in STATED if key in caps.fields], [])

    def test_hello_stops_and_sets_the_rate_to_0(self) -> None:
        desk = Desk()
        desk.machine.calls.clear()
        desk.say("HELLO proto=1")
        self.assertEqual(desk.machine.calls, ["stop", ("rate", 0.0)])

    def test_other_proto_gets_hello_only_and_no_session(self) -> None:
        desk = Desk().armed()
        self.assertEqual([line.word for line in desk.say("HELLO proto=2")], ["HELLO"])
        self.assertEqual(desk.machine.stops(), 1)
        self.assertEqual(desk.code("#2 STATUS"), "not_ready")

    def test_an_echo_of_our_hello_opens_nothing(self) -> None:
        desk = Desk()
        self.assertEqual(desk.one("HELLO proto=1 side=gateway").word, "EVENT")

    def test_hello_without_proto_is_reported(self) -> None:
        self.assertEqual(Desk().one("HELLO side=host").fields["kind"], "syntax")

    def test_nothing_is_accepted_before_hello_but_stop(self) -> None:
        desk = Desk()
        self.assertEqual(desk.code("#1 STATUS"), "not_ready")
        self.assertEqual(desk.one("STOP").fields["stops"], "1")
        self.assertEqual(desk.wait(2.0), [])

    def test_hello_begins_anew(self) -> None:
        desk = Desk().armed()
        desk.say("#2 RATE hz=100", "STOP")
        desk.say("HELLO proto=1")
        self.assertEqual(desk.code("#1 MOVE travel_mm=1 speed_mm_s=1"), "not_armed")
        self.assertEqual(desk.one("STOP").fields["stops"], "1")
        desk.session.samples([sample()] * 10)
        self.assertEqual(desk.said(), [])
        desk.say("#2 RATE hz=100")
        desk.session.samples([sample()] * 10)
        self.assertEqual(desk.said()[0].fields["seq"], "1")

    def test_done_of_the_old_session_is_not_told(self) -> None:
        desk = Desk().armed()
        desk.say("#2 MOVE travel_mm=1 speed_mm_s=1", "HELLO proto=1")
        self.assertEqual(desk.end("stop"), [])

    def test_limits_after_hello_wait_for_the_stop_of_hello(self) -> None:
        desk = Desk().armed()
        desk.machine.now = replace(STANDING, moving=True)
        desk.say("HELLO proto=1")
        self.assertEqual(desk.say(f"#1 {LIMITS}"), [])
        self.assertEqual(desk.wait(0.1), [])
        desk.machine.now = STANDING
        self.assertEqual(desk.wait(0.02)[0].word, "OK")

    def test_what_moves_for_long_is_busy(self) -> None:
        desk = Desk().armed()
        desk.machine.now = replace(STANDING, moving=True)
        desk.say("HELLO proto=1", f"#1 {LIMITS}")
        self.assertEqual([x.fields["code"] for x in desk.wait(0.6) if x.word == "ERR"], ["busy"])


class Observing(unittest.TestCase):
    def test_changes_nothing_at_the_machine(self) -> None:
        desk = Desk()
        desk.machine.calls.clear()
        words = [line.word for line in desk.say("OBSERVE proto=1 revision=2 hz=50")]
        desk.wait(3.0)
        desk.say("HB", "#1 MOVE travel_mm=1 speed_mm_s=1", "OBSERVE proto=1 hz=10")
        desk.session.closed()
        self.assertEqual(words, ["HELLO", "CAPS"])
        self.assertEqual(desk.machine.calls, [("rate", 50.0), ("rate", 10.0), ("rate", 0.0)])

    def test_whatever_carries_a_number_is_refused(self) -> None:
        desk = Desk()
        desk.say("OBSERVE proto=1 hz=0")
        for text in ("#1 STATUS", "#1 RATE hz=1", "#3 NONSENSE", "#2 MOVE x=1 x=1", "#4 HELLO proto=1"):
            self.assertEqual(desk.code(text), "observer")

    def test_rate_is_bounded(self) -> None:
        desk = Desk()
        desk.say("OBSERVE proto=1 hz=99999")
        self.assertIn(("rate", 500.0), desk.machine.calls)

    def test_stop_is_obeyed(self) -> None:
        desk = Desk()
        desk.say("OBSERVE proto=1 hz=0")
        desk.machine.calls.clear()
        self.assertEqual(desk.one("STOP").fields["stops"], "1")
        self.assertEqual(desk.machine.stops(), 1)

    def test_silence_only_ends_the_samples_until_it_is_heard_again(self) -> None:
        desk = Desk()
        desk.say("OBSERVE proto=1 hz=10")
        desk.session.samples([sample()])
        self.assertEqual(desk.said()[0].fields["seq"], "1")
        words = {line.word for line in desk.wait(1.1)}
        desk.session.samples([sample(), sample()])
        self.assertEqual((words, desk.said()), ({"HB"}, []))
        desk.say("HB")
        desk.session.samples([sample()])
        # the samples that were not sent show as a gap
        self.assertEqual(desk.said()[0].fields["seq"], "4")

    def test_observe_gives_the_command_back(self) -> None:
        desk = Desk().armed()
        desk.say("#2 MOVE travel_mm=1 speed_mm_s=1", "OBSERVE proto=1 hz=0")
        self.assertEqual(desk.machine.stops(), 1)
        self.assertEqual(desk.end("stop"), [])
        desk.say("HELLO proto=1")
        self.assertEqual(desk.code("#1 MOVE travel_mm=1 speed_mm_s=1"), "not_armed")

    def test_revision_1_does_not_know_the_word(self) -> None:
        desk = Desk(revision=1)
        self.assertEqual(desk.say("OBSERVE proto=1 hz=50", "#1 STATUS", "X"), [])
        hello, caps = desk.say("HELLO proto=1")
        for key in ("revision", "origin", "simulated"):
            self.assertNotIn(key, hello.fields)
        self.assertNotIn("force_lag_s", caps.fields)
        self.assertNotIn("force_class", caps.fields)
        self.assertEqual(desk.one("OBSERVE proto=1 hz=50").fields["kind"], "unknown")
        self.assertEqual(desk.one("#1 ZERO force=1").fields, {})


class Stopping(unittest.TestCase):
    def test_done_then_stopped_when_it_stands(self) -> None:
        desk = Desk().armed()
        desk.say("#2 MOVE travel_mm=1 speed_mm_s=1")
        desk.machine.now = replace(STANDING, moving=True)
        self.assertEqual(desk.say("STOP", "STOP"), [])
        desk.machine.now = STANDING
        done, stopped = desk.end("stop")
        self.assertEqual((done.fields["reason"], stopped.word, stopped.fields["stops"]),
                         ("stop", "STOPPED", "2"))

    def test_a_force_stop_on_its_way_keeps_its_reason(self) -> None:
        desk = Desk().armed()
        desk.say("#2 MOVEF force_N=1 speed_mm_s=1 guard_mm=5", "STOP")
        self.assertEqual([x.fields.get("reason") for x in desk.end("target")], ["target", None])

    def test_stop_is_not_queued_behind_a_command_that_blocks(self) -> None:
        desk = Desk().armed()
        desk.blocked = True
        desk.say("#2 STATUS")
        desk.say("STOP")
        self.assertEqual(desk.machine.stops(), 1)

    def test_what_waits_does_not_begin_after_stop(self) -> None:
        desk = Desk().armed()
        desk.blocked = True
        desk.say("#2 STATUS", "#3 MOVE travel_mm=1 speed_mm_s=1", "#4 RATE hz=5")
        self.assertEqual([(x.word, x.command) for x in desk.say("STOP")], [("ERR", 3), ("STOPPED", None)])
        desk.release()
        self.assertEqual([(x.word, x.command) for x in desk.said()], [("OK", 2), ("OK", 4)])
        self.assertFalse([c for c in desk.machine.calls if hasattr(c, "token")])

    def test_what_is_being_begun_is_stopped_again(self) -> None:
        desk = Desk().armed()
        desk.blocked = True
        desk.say("#2 MOVE travel_mm=1 speed_mm_s=1")
        desk.release(1)  # releases refresh(); start() is now in the command thread
        self.assertEqual(desk.say("STOP"), [])
        desk.release()
        self.assertEqual(desk.machine.stops(), 2)
        self.assertEqual([x.word for x in desk.said()], ["OK"])
        self.assertEqual([x.word for x in desk.end("stop")], ["DONE", "STOPPED"])

    def test_what_is_being_begun_when_the_session_ends_is_stopped_again(self) -> None:
        desk = Desk().armed()
        desk.blocked = True
        desk.say("#2 MOVE travel_mm=1 speed_mm_s=1")
        desk.release(1)
        desk.session.closed()
        desk.release()
        self.assertEqual(desk.machine.stops(), 2)

    def test_limits_stay(self) -> None:
        desk = Desk().armed()
        desk.say("STOP")
        self.assertEqual(desk.code("#2 MOVE travel_mm=1 speed_mm_s=1"), "OK")

    def test_no_motion_while_a_stop_is_carried_out(self) -> None:
        desk = Desk().armed()
        desk.machine.now = replace(STANDING, moving=True)
        desk.say("STOP")
        self.assertEqual(desk.code("#2 MOVE travel_mm=1 speed_mm_s=1"), "busy")

    def test_a_stop_with_a_number_stops_too(self) -> None:
        desk = Desk().armed()
        self.assertEqual([x.word for x in desk.say("#2 STOP")], ["ERR", "STOPPED"])
        self.assertEqual(desk.machine.stops(), 1)

    def test_hold_travel_ends_a_motion_with_stop(self) -> None:
        desk = Desk().armed()
        desk.say("#2 MOVE travel_mm=1 speed_mm_s=1")
        self.assertEqual(desk.code("#3 HOLD mode=travel"), "OK")
        self.assertEqual(desk.machine.stops(), 1)
        self.assertEqual(desk.end("stop")[0].fields["reason"], "stop")


class LifeSigns(unittest.TestCase):
    def test_heartbeat_after_250_ms(self) -> None:
        desk = Desk().armed()
        desk.machine.now = replace(STANDING, device_s=7.5)
        beats = [x for x in desk.wait(0.9) if x.word == "HB"]
        self.assertEqual((len(beats), beats[0].fields["t_s"]), (3, "7.5"))

    def test_silence_stops_forgets_and_says_so(self) -> None:
        desk = Desk().armed()
        desk.say("#2 MOVE travel_mm=1 speed_mm_s=1")
        desk.wait(0.99)
        self.assertEqual(desk.machine.stops(), 0)
        events = [x for x in desk.wait(0.02) if x.word == "EVENT"]
        self.assertEqual(([x.fields["kind"] for x in events], desk.machine.stops()), (["watchdog"], 1))
        (done,) = desk.end("stop")
        self.assertEqual((done.fields["reason"], done.fields["text"]), ("fault", "host silent"))
        self.assertEqual(desk.code("#3 MOVE travel_mm=1 speed_mm_s=1"), "not_armed")

    def test_limits_on_their_way_do_not_outlast_a_silence(self) -> None:
        desk = Desk().armed()
        desk.blocked = True
        desk.say(f"#2 {LIMITS}", f"#3 {LIMITS}")
        desk.release(1)
        desk.wait(1.1)
        desk.blocked = False
        desk.release()
        self.assertEqual([x.word for x in desk.said() if x.word != "HB"], ["ERR"])
        self.assertEqual(desk.code("#4 MOVE travel_mm=1 speed_mm_s=1"), "not_armed")

    def test_silence_is_told_once(self) -> None:
        desk = Desk().armed()
        self.assertEqual(len([x for x in desk.wait(5.0) if x.word == "EVENT"]), 1)

    def test_any_valid_line_is_a_life_sign(self) -> None:
        desk = Desk().armed()
        for number in range(2, 12):
            desk.say("HB" if number % 2 else f"#{number} NONSENSE", "WHAT")
            desk.wait(0.3)
        self.assertEqual(desk.machine.stops(), 0)

    def test_end_of_the_connection_stops(self) -> None:
        desk = Desk().armed()
        desk.session.closed()
        self.assertEqual(desk.machine.stops(), 1)

    def test_end_of_a_connection_without_session_stops_nothing(self) -> None:
        desk = Desk()
        desk.machine.calls.clear()
        desk.session.closed()
        self.assertEqual(desk.machine.stops(), 0)


class Reports(unittest.TestCase):
    def test_origin_that_others_changed(self) -> None:
        desk = Desk().armed()
        desk.session.origin_changed("o9", "tared at the panel")
        (event,) = desk.said()
        self.assertEqual((event.fields["kind"], event.fields["origin"]), ("origin", "o9"))

    def test_unknown_word(self) -> None:
        self.assertEqual(Desk().armed().one("GREETINGS").fields["kind"], "unknown")


if __name__ == "__main__":
    unittest.main()
