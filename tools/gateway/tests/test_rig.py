# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import json

from gateway.simulated.rig import BadRig, Rig, describe, parse_setting, parse_text, with_values


class Parameters(unittest.TestCase):
    def test_unknown_keys_are_refused_with_a_hint(self) -> None:
        with self.assertRaisesRegex(BadRig, "did you mean stiffness_N_mm"):
            with_values(Rig(), {"stifness_N_mm": 5})

    def test_wrong_kinds_and_ranges_are_refused(self) -> None:
        for key, value in (("stiffness_N_mm", "5"), ("stiffness_N_mm", True), ("stiffness_N_mm", None),
                           ("device_stop", 2), ("maker", 5), ("lost_probability", 1.5),
                           ("cell_noise_N", -1), ("start_travel_mm", 61), ("stiffness_N_mm", 99),
                           ("loop_delay_s", 0.04), ("cell_drift_N_s", float("nan"))):
            with self.subTest(key=key, value=value), self.assertRaises(BadRig):
                with_values(Rig(), {key: value})

    def test_settings(self) -> None:
        self.assertEqual(parse_setting("device_stop=0"), ("device_stop", 0))
        self.assertEqual(parse_setting("maker=ACME"), ("maker", "ACME"))
        with self.assertRaises(BadRig):
            parse_setting("maker")
        rig = with_values(Rig(), {"device_stop": 0, "declared_reaction_s": 0.5})
        self.assertEqual((rig.device_stop, rig.declared_reaction_s), (False, 0.5))

    def test_files_are_strict(self) -> None:
        for text in ('{"a": 1, "a": 2}', "[]", "{", '{"maker": "x",}'):
            with self.subTest(text=text), self.assertRaisesRegex(BadRig, "rig.json"):
                parse_text(text, "rig.json")

    def test_what_is_printed_can_be_read(self) -> None:
        rig = with_values(Rig(), {"stiffness_N_mm": 7, "maker": "ACME"})
        text = "\n".join(describe(rig))
        self.assertEqual(with_values(Rig(), parse_text(text, "rig.json")), rig)
        self.assertIn("// k of force", text)

    def test_every_key_has_its_unit(self) -> None:
        units = ("_mm", "_mm_s", "_mm_s2", "_s", "_N", "_N_mm", "_N_s", "_per_mm", "_hz", "_ppm",
                 "_um", "_mN", "_fraction", "_ratio", "_probability", "_class")
        flags_and_texts = [k for k, v in vars(Rig()).items() if isinstance(v, (bool, str))]
        for key in vars(Rig()):
            self.assertTrue(key.endswith(units) or key in flags_and_texts, key)

    def test_defaults_are_json(self) -> None:
        json.dumps(vars(Rig()), allow_nan=False)


if __name__ == "__main__":
    unittest.main()
