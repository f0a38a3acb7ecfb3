# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from gateway.protocol import (MAX_LINE_BYTES, Column, LineSplitter, Malformed, Missing, format_real,
                              parse, write)


class Reader(unittest.TestCase):
    def test_reads_word_number_and_fields(self) -> None:
        line = parse(b'#17 MOVE travel_mm=1.5 note="a \\"b\\" \\\\ =c" empty=""')
        self.assertEqual((line.word, line.command), ("MOVE", 17))
        self.assertEqual(line.real("travel_mm"), 1.5)
        self.assertEqual(line.text("note"), 'a "b" \\ =c')
        self.assertEqual(line.text("empty"), "")

    def test_number_may_follow_the_word(self) -> None:
        self.assertEqual(parse(b"OK #3").command, 3)

    def test_forgives_what_section_1_names(self) -> None:
        line = parse(b"  MOVE   travel_mm=+1  unknown=x \r")
        self.assertEqual(line.real("travel_mm"), 1.0)

    def test_refuses_bad_forms(self) -> None:
        for raw in (b"MOVE\tx=1", b"MOVE x=\x01", b"MOVE x=\x7f", "MOVE x=\u0085".encode(), b"MOVE x=\x00",
                    b"MOVE\rx=1", b"MOVE\r\r", b"MOVE x=1 x=1", b"MOVE x=1 y", b"MOVE FAST", b"x=1", b"#1",
                    b"#0 MOVE", b"#-1 MOVE", b"#1 #2 MOVE", b"#1.5 MOVE", b'MOVE x="a', b'MOVE x="a"b',
                    b'MOVE x=a"b', b'MOVE x="\\n"', b"MOVE x y=1", b"MOVE \xff", b"MOVE x-y=1", b"MOVE =1",
                    "MOVE l\u00e4nge=1".encode(), b"MOVE " + b" ".join(b"x%d=1" % i for i in range(101)),
                    b"MOVE x=" + b"a" * MAX_LINE_BYTES):
            with self.subTest(raw=raw[:40]), self.assertRaises(Malformed):
                parse(raw)

    def test_accepts_a_hundred_fields_and_a_full_line(self) -> None:
        parse(b"MOVE " + b" ".join(b"x%d=1" % i for i in range(100)))
        parse(b"MOVE x=" + b"a" * (MAX_LINE_BYTES - 7) + b"\r")

    def test_number_of_a_bad_line_is_known(self) -> None:
        for raw in (b"#7 MOVE x=\x01", b"#7 MOVE \xff", b"  #7 M x=1 x=2", b"MOVE #7 x=\x01",
                    b"#7 MOVE x=" + b"a" * MAX_LINE_BYTES):
            with self.subTest(raw=raw[:30]), self.assertRaises(Malformed) as caught:
                parse(raw)
            self.assertEqual(caught.exception.command, 7)

    def test_refuses_what_is_no_number(self) -> None:
        for value in ("1,5", "nan", "NaN", "inf", "-inf", "infinity", "1e5", "0x10", "1_0", "", "+", ".",
                      "1 ", "--1", "\u0661", "9" * 400):
            with self.subTest(value=value[:9]), self.assertRaises(Malformed):
                parse(f'MOVE x="{value}"'.encode()).real("x")

    def test_reads_numbers(self) -> None:
        for text, value in (("1", 1.0), ("+1.50", 1.5), ("-.5", -0.5), ("5.", 5.0),
                            ("0" * 400 + "7", 7.0)):
            self.assertEqual(parse(f"MOVE x={text}".encode()).real("x"), value)

    def test_flags(self) -> None:
        line = parse(b"ZERO force=1 travel=0 bad=2")
        self.assertEqual((line.flag("force"), line.flag("travel"), line.flag("absent")), (True, False, False))
        with self.assertRaises(Malformed):
            line.flag("bad")

    def test_missing_is_not_malformed(self) -> None:
        with self.assertRaises(Missing):
            parse(b"MOVE").real("travel_mm")


class Writer(unittest.TestCase):
    def test_writes_numbers_without_exponent(self) -> None:
        for value, text in ((0.0, "0"), (4.02, "4.02"), (1e-7, "0.0000001"),
                            (1.5e22, "15000000000000000000000"),
                            (-0.1, "-0.1"), (20.0, "20")):
            self.assertEqual(format_real(value), text)
            self.assertEqual(float(format_real(value)), value)

    def test_refuses_what_is_no_number(self) -> None:
        for value in (float("nan"), float("inf")):
            with self.assertRaises(ValueError):
                format_real(value)

    def test_writes_fields(self) -> None:
        raw = write("DONE", {"reason": "target", "force_N": None, "text": "", "n": 3, "yes": True},
                    answer_to=5)
        self.assertEqual(raw, b'DONE #5 reason=target text="" n=3 yes=1\n')

    def test_text_survives(self) -> None:
        for text in ('a "b" \\ c', "17", "ä=ö", "", " "):
            self.assertEqual(parse(write("EVENT", {"text": text}).rstrip(b"\n")).text("text"), text)

    def test_text_cannot_break_a_line(self) -> None:
        raw = write("EVENT", {"text": "a\nSTOP\r\x00\ud800" + "b" * 100000})
        self.assertEqual(raw.count(b"\n"), 1)
        self.assertTrue(parse(raw.rstrip(b"\n")).text("text").startswith("a?STOP???b"))

    def test_columns(self) -> None:
        raw = write("S", {"seq": 1, "n": 3, "force_N": Column([0.1, None, 2.0]),
                          "flags": Column(["M", "-", "M"])})
        self.assertEqual(raw, b"S seq=1 n=3 force_N=0.1,,2 flags=M,-,M\n")


class Splitter(unittest.TestCase):
    def test_any_cut_gives_the_same_lines(self) -> None:
        data = b"STOP\n\nHB t_s=1\r\n#1 STATUS\nrest"
        for size in range(1, len(data)):
            splitter = LineSplitter()
            pieces = [data[i:i + size] for i in range(0, len(data), size)]
            lines = [line for piece in pieces for line in splitter.feed(piece)]
            self.assertEqual(lines, [b"STOP", b"", b"HB t_s=1\r", b"#1 STATUS"])

    def test_a_line_without_end_takes_no_memory_and_is_refused(self) -> None:
        splitter = LineSplitter()
        for _ in range(100):
            self.assertEqual(list(splitter.feed(b"#3 MOVE " + b"a" * 10000)), [])
        (line, after) = list(splitter.feed(b"\nSTOP\n"))
        self.assertLess(len(line), MAX_LINE_BYTES + 10)
        with self.assertRaises(Malformed) as caught:
            parse(line)
        self.assertEqual((caught.exception.command, after), (3, b"STOP"))


if __name__ == "__main__":
    unittest.main()
