# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from gateway.check.form import complaints


class Form(unittest.TestCase):
    def test_good_lines_pass(self) -> None:
        for raw in (b'HELLO proto=1 revision=2 side=gateway origin="17" version="1.0"', b"HB t_s=1.25",
                    b'ERR #2 code="not_armed" text="send  LIMITS"', b"STOPPED stops=3",
                    b"S seq=101 n=3 t_s=4.02,4.04,4.06 force_N=0.1213,,0.1251 flags=M,MO,M",
                    b"DONE #5 reason=target force_N=-1.5 text=\"\""):
            self.assertEqual(list(complaints(raw)), [], raw)

    def test_bad_lines_do_not(self) -> None:
        for raw in (b"HB\r", b"HB  t_s=1", b"HB ", b"HB t_s=1e5", b"HB t_s=+1", b"HB t_s=.5", b"NEWS x=1",
                    b"ERR #1 code=what", b"DONE #1 reason=bored", b"STOPPED stops=1.0", b"S n=1 t_s=1",
                    b"S seq=0 n=1 t_s=1", b"S seq=1 n=2 t_s=1", b"S seq=1 n=2 t_s=,", b"S seq=1 n=2 flags=X",
                    b"S seq=1 n=2 force_N=1,2 flags=O,M", b"CAPS motion=yes", b"S seq=1 n=3 flags=M,M"):
            self.assertTrue(list(complaints(raw)), raw)


if __name__ == "__main__":
    unittest.main()
