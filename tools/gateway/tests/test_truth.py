# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import io
import json
import time
from typing import Any

from gateway.simulated.truth import Truth


class Kept(io.StringIO):
    """A file whose text outlives close()."""

    def close(self) -> None:
        self.text = self.getvalue()


def state(**changes: Any) -> dict[str, Any]:
    return {"t_s": 0.0, "force_N": 0.0, "travel_mm": 1.0, "peak_force_N": 0.5, "moving": False,
            "turning": False, "max_travel_mm": 2.0, "motions": 0, **changes}


class Lines(unittest.TestCase):
    def setUp(self) -> None:
        self.file = Kept()
        self.truth = Truth(self.file)

    def lines(self) -> list[dict[str, Any]]:
        self.truth.close()
        return [json.loads(line) for line in self.file.text.splitlines()]

    def test_counts_words_and_bytes_per_kind_of_session(self) -> None:
        truth = self.truth
        truth.session("none")
        truth.received_bytes(10)
        truth.session("observer")
        truth.received_bytes(5)
        for word, command in (("OBSERVE", None), ("HB", None), ("STOP", None), ("MOVE", 3), ("", 4),
                              ("WHAT", None)):
            truth.received_line(word, command, "text")
        summary = self.lines()[-1]
        self.assertEqual((summary["bytes_none"], summary["bytes_observer"], summary["bytes_received"]),
                         (10, 5, 15))
        self.assertEqual([summary[key] for key in ("observes", "life_signs", "stops", "commands",
                                                   "malformed", "other", "hellos")], [1, 1, 1, 1, 1, 1, 0])

    def test_braking_is_no_motion_after_stop(self) -> None:
        self.truth.received_line("STOP", None, "STOP")
        self.truth.put("", state=state(moving=True, turning=True))
        self.truth.put("", state=state())
        self.assertIs(self.lines()[-1]["moved_after_last_stop"], False)

    def test_motion_after_stop_is_told_until_the_next_stop(self) -> None:
        for word_last, expected in ((False, True), (True, False)):
            self.setUp()
            self.truth.received_line("STOP", None, "STOP")
            self.truth.put("", state=state())
            self.truth.put("", state=state(moving=True, turning=True))
            if word_last:
                self.truth.received_line("STOP", None, "STOP")
            self.assertIs(self.lines()[-1]["moved_after_last_stop"], expected)

    def test_without_a_stop_nothing_is_said(self) -> None:
        self.assertIsNone(self.lines()[-1]["moved_after_last_stop"])

    def test_every_line_is_there_at_once(self) -> None:
        self.truth.put("standing", state=state())
        deadline_s = time.monotonic() + 5
        while "standing" not in self.file.getvalue() and time.monotonic() < deadline_s:
            time.sleep(0.001)
        self.assertEqual(json.loads(self.file.getvalue())["event"], "standing")
        self.truth.close()


if __name__ == "__main__":
    unittest.main()
