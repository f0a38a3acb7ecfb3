# SPDX-License-Identifier: Apache-2.0
"""Lies as a daemon meets them: as options of the program, and over the link."""

import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import subprocess
import time

from gateway.tests.support import PROGRAM, Gateway, Link

_LIMITS = "LIMITS force_min_N=-1 force_max_N=5 travel_min_mm=0 travel_max_mm=25 speed_max_mm_s=5"
_HELLO = "HELLO proto=1 revision=2 side=host"


def armed(link: Link) -> Link:
    link.send(_HELLO, "#1 RATE hz=50", f"#2 {_LIMITS}")
    link.until("CAPS")
    link.until("OK")
    link.until("OK")
    return link


class Program(unittest.TestCase):
    def output(self, *options: str) -> tuple[int, str, str]:
        done = subprocess.run(["/usr/bin/python3", str(PROGRAM), *options], capture_output=True, text=True,
                              timeout=20)
        return done.returncode, done.stdout, done.stderr

    def test_lists_and_refuses(self) -> None:
        code, out, _ = self.output("--list-lies")
        self.assertEqual(code, 0)
        self.assertIn("stop_unconfirmed", out)
        self.assertIn("    speed_um_s ", out)
        self.assertIn("  caps_changed  ", self.output("--help")[1])
        code, _, errors = self.output("--lie", "forcefrozen")
        self.assertEqual(code, 2)
        self.assertIn("did you mean force_frozen?", errors)
        code, _, errors = self.output("--backend", "x:y", "--lie", "estop")
        self.assertEqual((code, "only the simulated machine" in errors), (2, True))

    def test_what_begins_is_said_and_what_does_not_is_warned_of(self) -> None:
        with Gateway("--lie", "clock_frozen,at_s=0.1", "--lie", "estop,motion=9") as gateway:
            self.assertTrue(gateway.ready)
            lie = gateway.await_event("lie")
            self.assertEqual((lie["name"], lie["on"], lie["force_N"]), ("clock_frozen", True, 0.0))
            _, errors = gateway.end()
        self.assertIn("lie clock_frozen begins at 0.1", errors)
        self.assertIn("lie estop had no occasion", errors)


class OverTheLink(unittest.TestCase):
    def test_stop_is_obeyed_and_not_answered(self) -> None:
        with Gateway("--lie", "stop_unconfirmed") as gateway, Link(gateway.address()) as link:
            armed(link).send("#3 MOVE travel_mm=15 speed_mm_s=1")
            gateway.await_event("motion_begin")
            link.send("STOP")
            self.assertEqual(link.until("DONE").text("reason"), "stop")
            link.send("#4 STATUS")
            words = []
            for line in link.lines():
                words.append(line.word)
                if line.command == 4:
                    break
            self.assertNotIn("STOPPED", words)

    def test_done_late_does_not_hold_up_stopped(self) -> None:
        with Gateway("--lie", "done_late,delay_s=3") as gateway, Link(gateway.address()) as link:
            armed(link).send("#3 MOVE travel_mm=10.1 speed_mm_s=1")
            gateway.await_event("motion_end")
            link.send("STOP")
            begun_s = time.monotonic()
            self.assertEqual(link.until("DONE").text("reason"), "target")
            link.until("STOPPED")
            self.assertLess(time.monotonic() - begun_s, 1.5)

    def test_a_restart_that_forgot_its_tare(self) -> None:
        for told in (0, 1):
            lie = f"tare_lost,motion=1,after_s=0.2,restart=1,origin_changes={told}"
            with Gateway("--lie", lie, cell_offset_N=0.4) as gateway:
                with Link(gateway.address()) as link:
                    armed(link).send("#3 ZERO force=1")
                    origin = link.until("OK").text("origin")
                    link.send("#4 MOVE travel_mm=15 speed_mm_s=1")
                    self.assertEqual([line.word for line in link.lines() if line.word == "DONE"], [])
                with Link(gateway.address()) as link:
                    link.send(_HELLO, "#1 RATE hz=50")
                    self.assertEqual(link.until("HELLO").text("origin") != origin, bool(told))
                    force_N = float(link.until("S").text("force_N").split(",")[0])
                    self.assertAlmostEqual(force_N, 0.4, delta=0.01)

    def test_a_restart_with_other_caps(self) -> None:
        with Gateway("--lie", "caps_changed,motion=1,after_s=0.2") as gateway:
            with Link(gateway.address()) as link:
                armed(link).send("#3 MOVE travel_mm=15 speed_mm_s=1")
                list(link.lines())
            with Link(gateway.address()) as link:
                link.send(_HELLO)
                self.assertEqual(link.until("CAPS").real("speed_max_mm_s"), 10.0)

    def test_estop_is_reported_refused_and_released(self) -> None:
        with Gateway("--lie", "estop,motion=1,after_s=0.2,for_s=0.6") as gateway, \
                Link(gateway.address()) as link:
            armed(link).send("#3 MOVE travel_mm=15 speed_mm_s=1")
            self.assertEqual(link.until("EVENT").text("kind"), "estop")
            self.assertEqual(link.until("DONE").text("reason"), "fault")
            link.send("#4 MOVE travel_mm=15 speed_mm_s=1")
            self.assertEqual(link.until("ERR").text("code"), "not_ready")
            while len(gateway.events("lie")) < 2:
                time.sleep(0.02)
            time.sleep(0.1)
            link.send("HB", "#5 MOVE travel_mm=10 speed_mm_s=1")
            self.assertEqual(link.until("OK").command, 5)

    def test_a_lie_begins_from_the_panel(self) -> None:
        with Gateway() as gateway, Link(gateway.address()) as link, \
                Link(gateway.address("panel")) as panel:
            armed(link)
            panel.send('LIE text="crep"', 'LIE text="force_drift,rate_N_s=1"')
            self.assertIn("did you mean creep?", panel.until("ERR").text("text"))
            panel.until("OK")
            self.assertEqual(gateway.await_event("lie")["name"], "force_drift")

    def test_creep_is_motion_to_the_witness(self) -> None:
        with Gateway("--lie", "creep,speed_um_s=100") as gateway, \
                Link(gateway.address()) as link:
            armed(link).send("#3 MOVE travel_mm=10.1 speed_mm_s=1")
            link.until("DONE")
            time.sleep(0.3)
            link.send("STOP", "#4 STATUS")
            link.until("STOPPED")
            gateway.end()
            last = gateway.truth()[-1]
            self.assertGreater(last["travel_mm"], 10.12)
            self.assertTrue(last["moving"])


if __name__ == "__main__":
    unittest.main()
