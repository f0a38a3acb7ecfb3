# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import random
from collections import Counter
from dataclasses import replace

from gateway.backend import Ended
from gateway.protocol import Line
from gateway.tests.support import LIMITS, STANDING, Desk, sample

_LINES = ["STOP", "HB", "STATUS", "RATE hz=50", "RATE hz=x", LIMITS, LIMITS, "ZERO force=1",
          "MOVE travel_mm=1 speed_mm_s=1", "MOVE travel_mm=-1 speed_mm_s=0.5",
          "MOVE travel_mm=9 speed_mm_s=1",
          "MOVEF force_N=1 speed_mm_s=0.1 guard_mm=4", "RAMPF force_N=1 rate_N_s=1", "HOLD mode=travel",
          "HOLD mode=force force_N=1", "MOVE travel_mm=1 travel_mm=1", "NOISE \x01"]


class Ledger:
    """Follows one session from outside and reports violations."""

    def __init__(self, test: unittest.TestCase) -> None:
        self.test = test
        self.reset()

    def reset(self) -> None:
        self.asked: dict[int, str] = {}
        self.answers: Counter[int] = Counter()
        self.begun: list[int] = []
        self.armed = False
        self.stops = 0
        self.told = 0

    def see(self, line: Line) -> None:
        number = line.command
        if line.word in ("OK", "ERR") and number is not None:
            self.test.assertIn(number, self.asked)
            self.answers[number] += 1
            self.test.assertEqual(self.answers[number], 1, f"#{number} was answered twice")
            if line.word == "OK":
                self.accepted(number, self.asked[number])
        elif line.fields.get("kind") == "watchdog":
            self.armed = False
        elif line.word == "DONE" and number is not None:
            self.test.assertIn(number, self.begun, "DONE without OK")
            self.begun.remove(number)
        elif line.word == "STOPPED":
            stops = int(line.fields["stops"])
            self.test.assertTrue(self.told < stops <= self.stops, f"stops={stops}")
            self.told = stops

    def accepted(self, number: int, text: str) -> None:
        if text == LIMITS:
            self.armed = True
        elif text.startswith(("MOVE", "RAMPF", "HOLD mode=force")):
            self.test.assertTrue(self.armed, f"{text} without limits")
            self.test.assertFalse(self.begun, f"{text} during a motion")
            if not text.startswith("HOLD"):
                self.begun.append(number)


class RandomSessions(unittest.TestCase):
    """For any sequence of lines: one answer per command, DONE after OK, nothing begins without
    limits or twice, and every STOP is answered in the end."""

    def test_hundreds(self) -> None:
        for seed in range(150):
            with self.subTest(seed=seed):
                self.session(random.Random(seed))

    def session(self, rng: random.Random) -> None:
        desk, ledger = Desk(), Ledger(self)
        number = 0
        for _ in range(60):
            what = rng.random()
            if what < 0.05:
                desk.said()
                desk.say(rng.choice(["HELLO proto=1", "HELLO proto=1", "OBSERVE proto=1 hz=5"]))
                ledger.reset()
                number = 0
            elif what < 0.6:
                number = self.say(rng, desk, ledger, number)
            elif what < 0.75:
                self.end_a_motion(rng, desk)
            elif what < 0.85:
                desk.blocked = rng.random() < 0.5
                desk.release(rng.randrange(3))
            else:
                desk.session.samples([sample()])
                self.wait(desk, ledger, rng.choice([0.01, 0.3, 1.2]))
            for line in desk.said():
                ledger.see(line)
        self.settle(desk, ledger)

    def say(self, rng: random.Random, desk: Desk, ledger: Ledger, number: int) -> int:
        text = rng.choice(_LINES)
        if text == "STOP":
            ledger.stops += 1
        elif text != "HB":
            number += 1
            ledger.asked[number] = text
            text = f"#{number} {text}"
        desk.session.received(text.encode())
        return number

    def end_a_motion(self, rng: random.Random, desk: Desk) -> None:
        motions = [c for c in desk.machine.calls if hasattr(c, "token")]
        if motions:
            desk.session.ended(Ended(rng.choice(motions).token, rng.choice(["target", "stop"])))

    def wait(self, desk: Desk, ledger: Ledger, seconds: float) -> None:
        desk.machine.now = replace(STANDING, moving=seconds < 0.1)
        for line in desk.wait(seconds, 0.05):
            ledger.see(line)

    def settle(self, desk: Desk, ledger: Ledger) -> None:
        """All motions end, and every line is answered."""
        desk.blocked = False
        desk.release()
        for call in list(desk.machine.calls):
            if hasattr(call, "token"):
                desk.session.ended(Ended(call.token, "stop"))
        self.wait(desk, ledger, 1.0)
        for line in desk.said():
            ledger.see(line)
        self.assertEqual(ledger.told, ledger.stops)
        self.assertEqual(set(ledger.answers), set(ledger.asked))


if __name__ == "__main__":
    unittest.main()
