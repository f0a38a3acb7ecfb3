// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/forecast.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "protocols/plan/rig_forecast.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

FrameCapabilities frame(Duration reaction = 20ms) {
  FrameCapabilities c;
  c.device_stop = true;
  c.reaction = reaction;
  c.deceleration = 0.05_m_s2;
  c.speed_min = Velocity::from_si(1e-7);
  c.force_loop.emplace();
  c.force_loop->approach = 0.1_mm_s;
  c.force_loop->contact = Force::from_si(0.01);
  c.force_loop->rate_max = 5.0_N_s;
  c.force_loop->lag = 40ms;
  c.force_loop->ripple = Force::from_si(0.01);
  c.force_loop->stiffness_max = 200.0_N_mm;
  return c;
}

Forecast of(double bound_N_m, std::optional<double> expected_N_m = std::nullopt) {
  std::optional<ForceBound> expected;
  if (expected_N_m) expected.emplace(Compression(), *expected_N_m);
  return Forecast(frame(), ForceBound({}, bound_N_m), std::move(expected));
}

// By hand, v tau + v^2/2a: k 100 N/mm, 60 mm/min, 1 ms and 20 ms, a = 50 mm/s2: 1.1 and 3.0 N.
TEST(Forecast, AgreesWithTheReferenceTable) {
  const ForceBound contact({}, 100e3);
  EXPECT_NEAR(Forecast(frame(1ms), contact, {}).stop_N(0, 1e-3), 1.1, 0.01);
  EXPECT_NEAR(Forecast(frame(), contact, {}).stop_N(0, -1e-3), 3.0, 0.01);
}

TEST(Forecast, TheFastestSpeedEndsExactlyAtTheLimit) {
  const Forecast f = of(120e3);
  const double v = f.fastest_m_s(0.5, 1.5);
  EXPECT_GT(v, 0);
  EXPECT_NEAR(f.stop_N(0.5, v), 1.5, 1e-9);
  EXPECT_EQ(f.fastest_m_s(1.5, 1.5), 0);
}

TEST(Forecast, ATripEndsAtTheLimit) {
  const Forecast f = of(120e3);
  const double trip = f.trip_N(0.2e-3, 1.5);
  EXPECT_NEAR(f.stop_N(trip, 0.2e-3), 1.5, 1e-9);
}

TEST(Forecast, AHostSideStopTakesTheHostsTimeToo) {
  FrameCapabilities polled = frame();
  polled.device_stop = false;
  EXPECT_NEAR(stopping_way_m(polled, 1e-3) - stopping_way_m(frame(), 1e-3), 20e-6, 1e-12);
}

TEST(Forecast, ARampPassesItsTargetByLagAndRipple) {
  const Forecast f = of(50e3);
  EXPECT_NEAR(f.ramp_N(0.5, 1, 0.2), 1 + 0.2 * 0.04 + 0.01, 1e-9);
  EXPECT_NEAR(f.fastest_ramp_N_s(1, 1.11), 0.1 / 0.04, 1e-9);
  EXPECT_EQ(f.fastest_ramp_N_s(1, 1.005), 0);
  // A ramp that starts without contact also meets the specimen, at a speed of its own.
  const double met = f.stop_N(0.01, 0.1e-3);
  EXPECT_NEAR(f.ramp_N(0, 0.02, 0.001), met, 1e-9);
}

TEST(Forecast, AMeasuredStiffnessIsTrustedWithAMargin) {
  Forecast f = of(1000e3, 60e3);
  const double v = 0.016e-3;
  EXPECT_GT(f.stop_N(1, v), 1.3);
  EXPECT_FALSE(f.stop_if_measured_N(1, v)) << "nobody searches for contact";
  f.expect_measurement(2);
  ASSERT_TRUE(f.stop_if_measured_N(0.5, v));
  EXPECT_NEAR(*f.stop_if_measured_N(0.5, v) - 0.5, 1.5 * (*f.expected_stop_N(0.5, v) - 0.5), 1e-6);
  f.measured(2, 80e3);
  EXPECT_TRUE(f.is_measured());
  EXPECT_NEAR(f.stop_N(0.5, v) - 0.5, 1.5 * 80e3 * stopping_way_m(frame(), v), 1e-6);
}

// F = k x (1 + c x): a stop at a small force has seen little of the curvature. k(F) = k0 sqrt(1 + 4
// c F/k0).
TEST(Forecast, AnyCurvatureOfTheContactIsWithinWhatWasMeasuredBeforeIt) {
  const double k0 = 30e3;
  for (const double c : {0.0, 100.0, 3e3, 1e5, 1e7}) {
    const auto slope = [&](double force) { return k0 * std::sqrt(1 + 4 * c * force / k0); };
    const auto depth = [&](double force) { return (slope(force) / k0 - 1) / (2 * c); };
    Forecast f = of(1000e3, 30e3);
    const double felt = 0.03;
    f.measured(felt, c > 0 ? felt / 2 / (depth(felt) - depth(felt / 2)) : k0);
    for (const double force : {0.05, 0.2, 1.0, 1.4}) {
      EXPECT_GE(f.bound().stiffness_N_m(force), std::min(slope(force), 0.99 * 1000e3))
          << c << " 1/m at " << force << " N";
    }
  }
}

// The specimen's file may say that its layers are held where they are not. Pressed flat, a free one
// stiffens far more.
TEST(Forecast, AMeasuredStiffnessGrowsAsThatOfAFreeSpecimenDoesIfThatIsMore) {
  const ForceBound flat([](double force) { return 1e-3 * (1 - 1 / std::sqrt(1 + 1e2 * force)); });
  Forecast f(frame(), ForceBound({}, 1000e3), ForceBound({}, 60e3), flat);
  f.measured(0.04, flat.stiffness_N_m(0.02));
  for (const double force : {0.05, 0.5, 2.0}) {
    EXPECT_GE(f.bound().stiffness_N_m(force), flat.stiffness_N_m(force)) << force << " N";
  }
}

TEST(Forecast, IsNowhereBelowTheContactThatTheModelExpects) {
  Rig rig;
  rig.frame = frame();
  rig.specimen_least_m = [](double force) { return 20e-6 * force; };
  rig.compression_m = [](double force) { return 20e-6 * std::sqrt(force); };  // stiffer from 0.25 N
  Forecast f = make_forecast(rig);
  f.expect_measurement(0.1);
  for (const double force : {0.01, 0.1, 0.5, 2.0}) {
    for (const double speed : {1e-5, 1e-3}) {
      EXPECT_GE(f.stop_N(force, speed), *f.expected_stop_N(force, speed)) << force << " N";
      EXPECT_GE(*f.stop_if_measured_N(force, speed), *f.expected_stop_N(force, speed));
    }
  }
}

TEST(Forecast, ALoopIsGoodForItsContactsOnly) {
  EXPECT_TRUE(of(150e3).loop_can_hold(1));
  EXPECT_FALSE(of(500e3).loop_can_hold(1));
  Forecast f = of(500e3, 60e3);
  EXPECT_FALSE(f.loop_can_hold_if_measured(1)) << "nobody searches for contact";
  f.expect_measurement(1);
  EXPECT_TRUE(f.loop_can_hold_if_measured(1));
}

TEST(Forecast, WithoutADecelerationAFrameStopsAfterItsReaction) {
  FrameCapabilities hard = frame();
  hard.deceleration = Acceleration();
  EXPECT_NEAR(speed_within_m_s(hard, 1e-4), 1e-4 / 0.02, 1e-12);
  EXPECT_NEAR(stopping_way_m(hard, 5e-3), 1e-4, 1e-12);
  hard.reaction = 0ms;
  EXPECT_TRUE(std::isinf(speed_within_m_s(hard, 1e-4)));
  EXPECT_EQ(speed_within_m_s(hard, 0), 0);
}

TEST(Forecast, AFilterSettlesWhileABatchIsUnderWay) {
  FrameCapabilities caps = frame();
  EXPECT_EQ(settles_after(caps), 0ms) << "no filter";
  caps.filter = 10ms;
  EXPECT_EQ(settles_after(caps), 0ms);
  caps.filter = 100ms;
  EXPECT_NEAR(to_seconds(settles_after(caps)), 0.4, 1e-9);
  EXPECT_NEAR(to_seconds(shown_after(caps)), 0.5, 1e-9);
}

// A model that gives way nowhere says nothing of how a contact stiffens.
TEST(Forecast, AnUnboundedModelDoesNotStiffenAMeasurement) {
  const ForceBound rigid{Compression()};
  Forecast f(frame(), ForceBound({}, 1000e3), ForceBound({}, 60e3), rigid);
  f.measured(2, 80e3);
  EXPECT_NEAR(f.bound().stiffness_N_m(1), 1.5 * 80e3, 3e3);
}

TEST(Forecast, TheFastestSpeedAfterAMeasurementIsThatOfWhatItShouldFind) {
  Forecast f = of(1000e3, 60e3);
  EXPECT_EQ(f.fastest_if_measured_m_s(0.5, 1.5), 0) << "nobody searches for contact";
  f.expect_measurement(2);
  const double v = f.fastest_if_measured_m_s(0.5, 1.5);
  EXPECT_GT(v, f.fastest_m_s(0.5, 1.5));
  EXPECT_NEAR(*f.stop_if_measured_N(0.5, v), 1.5, 1e-9);
}

// A specimen that stiffens: the measurement is a slope at half of the force where it is made.
TEST(Forecast, AMeasurementShouldFindTheStiffnessAtHalfOfItsForce) {
  const ForceBound expected([](double force) { return 20e-6 * std::sqrt(force); });
  Forecast f(frame(), ForceBound({}, 1e9), expected);
  f.expect_measurement(2);
  // At 1 N it is what the model says, and 1.5 times that is trusted.
  EXPECT_NEAR(*f.stop_if_measured_N(0.99, 1e-6) - 0.99,
              1.5 * expected.stiffness_N_m(1) * stopping_way_m(frame(), 1e-6), 2e-4);
}

TEST(Forecast, AHostThatIsLostIsNoticedAfterASecond) {
  EXPECT_NEAR(of(50e3).lost_way_m(1e-4), 1e-4 * 1.02 + stopping_way_m(frame(), 1e-4), 1e-9);
}

TEST(Forecast, OfARampSaysNothingOfAMeasurementThatNobodyMakes) {
  Forecast f = of(500e3, 60e3);
  EXPECT_FALSE(f.ramp_if_measured_N(0.5, 1, 0.2));
  f.expect_measurement(1);
  ASSERT_TRUE(f.ramp_if_measured_N(0.5, 1, 0.2));
  EXPECT_NEAR(*f.ramp_if_measured_N(0.5, 1, 0.2), 1 + 0.2 * 0.04 + 0.01, 1e-9);
}

}  // namespace
}  // namespace lcrig
