# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from gateway.backend import Ended
from gateway.simulated.delivery import Delivery, Sampler
from gateway.simulated.rig import Rig, with_values
from gateway.tests.support import sample


class Delays(unittest.TestCase):
    def delivery(self, **rig: float) -> Delivery:
        return Delivery(with_values(Rig(), rig))

    def test_as_they_come(self) -> None:
        delivery = self.delivery()
        delivery.put(1.0, sample())
        self.assertEqual(len(delivery.take(1.0)), 1)

    def test_late(self) -> None:
        delivery = self.delivery(delivery_delay_s=0.1)
        delivery.put(1.0, sample())
        self.assertEqual((len(delivery.take(1.09)), len(delivery.take(1.11))), (0, 1))

    def test_in_bursts(self) -> None:
        delivery = self.delivery(burst_period_s=0.5)
        for t_s in (1.1, 1.2, 1.3):
            delivery.put(t_s, sample())
        self.assertEqual((len(delivery.take(1.49)), len(delivery.take(1.5))), (0, 3))

    def test_the_end_of_a_motion_takes_its_samples_along(self) -> None:
        delivery = self.delivery(burst_period_s=0.5, delivery_delay_s=0.1)
        delivery.put(1.1, sample())
        delivery.put(1.2, Ended(1, "target"))
        items = delivery.take(1.31)
        self.assertEqual([type(item).__name__ for item in items], ["Sample", "Ended"])

    def test_no_sample_outlives_rate_0(self) -> None:
        delivery = self.delivery(delivery_delay_s=1.0)
        delivery.put(1.0, sample())
        delivery.put(1.0, Ended(1, "stop"))
        delivery.drop_samples()
        self.assertEqual(len(delivery.take(9.0)), 1)


class Taking(unittest.TestCase):
    def taken(self, seconds: float, hz: float, **rig: float) -> list[object]:
        sampler = Sampler(with_values(Rig(), {"clock_error_ppm": 0, **rig}), 1)
        sampler.set_rate(hz, 0)
        every = [sampler.take(step, sample) for step in range(1, round(seconds * 5000) + 1)]
        return [s for s in every if s]

    def test_rate(self) -> None:
        self.assertEqual(len(self.taken(2.0, 500)), 1000)
        self.assertEqual(len(self.taken(2.0, 1000, rate_max_hz=1000)), 2000)
        self.assertEqual(len(self.taken(3.1, 7)), 21)
        self.assertEqual(len(self.taken(3.0, 0)), 0)

    def test_a_fast_clock_samples_faster(self) -> None:
        self.assertEqual(len(self.taken(2.0, 100, clock_error_ppm=10000)), 202)

    def test_what_is_lost_or_missing(self) -> None:
        samples = self.taken(2.0, 500, lost_probability=0.1, missing_force_probability=0.2,
                             missing_t_probability=1.0, missing_travel_probability=0.3)
        lost = sum(s.lost_before for s in samples)  # type: ignore[attr-defined]
        self.assertTrue(70 < lost < 130 and len(samples) + lost >= 998)
        self.assertEqual({s.t_s for s in samples}, {None})  # type: ignore[attr-defined]
        without = sum(s.force_N is None for s in samples)  # type: ignore[attr-defined]
        self.assertTrue(120 < without < 240)


if __name__ == "__main__":
    unittest.main()
