# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from gateway.protocol import parse
from gateway.sample_lines import SampleLines
from gateway.tests.support import sample


class Batches(unittest.TestCase):
    def setUp(self) -> None:
        self.sent: list[bytes] = []
        self.lines = SampleLines(self.sent.append)
        self.lines.set_rate(50)

    def test_a_line_covers_100_ms(self) -> None:
        self.lines.add([sample()] * 12, 0.0)
        self.assertEqual([parse(x.rstrip()).fields["n"] for x in self.sent], ["5", "5"])
        self.lines.flush()
        self.assertEqual(parse(self.sent[-1].rstrip()).fields["seq"], "11")

    def test_one_sample_may_always_be_sent(self) -> None:
        self.lines.set_rate(0.5)
        self.lines.add([sample()], 0.0)
        self.assertEqual(len(self.sent), 1)

    def test_a_few_samples_do_not_wait_for_longer(self) -> None:
        self.lines.add([sample()], 7.0)
        self.assertAlmostEqual(self.lines.due_s(), 7.1)

    def test_missing_values_and_columns(self) -> None:
        self.lines.add([sample(t_s=None), sample(t_s=None, force_N=None),
                        sample(t_s=None, force_N=-1e-7)], 0.0)
        self.lines.flush()
        fields = parse(self.sent[0].rstrip()).fields
        self.assertEqual(fields["force_N"], "0.5,,-0.0000001")
        self.assertNotIn("t_s", fields)

    def test_flags(self) -> None:
        self.lines.add([sample(), sample(moving=True, force_control=True),
                        sample(moving=True, overload=True, force_N=9.0)], 0.0)
        self.lines.add([sample(flags_known=False), sample()], 0.0)
        fields = parse(self.sent[0].rstrip()).fields
        self.assertEqual((fields["flags"], fields["force_N"]), ("-,MF,MO,,-", "0.5,0.5,,0.5,0.5"))

    def test_one_flag_stands_for_all(self) -> None:
        self.lines.add([sample(moving=True)] * 5, 0.0)
        self.assertEqual(parse(self.sent[0].rstrip()).fields["flags"], "M")

    def test_lost_samples_are_a_hole(self) -> None:
        self.lines.add([sample(), sample(lost_before=3), sample()], 0.0)
        self.lines.flush()
        self.assertEqual([parse(x.rstrip()).fields["seq"] for x in self.sent], ["1", "5"])


if __name__ == "__main__":
    unittest.main()
