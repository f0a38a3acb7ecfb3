// SPDX-License-Identifier: Apache-2.0
#include "protocols/watch/pressing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

FrameCapabilities frame() {
  FrameCapabilities c;
  c.motion = c.device_stop = true;
  c.force_max = 20.0_N;
  c.speed_max = 10.0_mm_s;
  c.travel_min = Length();
  c.travel_max = 60.0_mm;
  c.reaction = 8ms;
  c.deceleration = 0.2_m_s2;
  return c;
}

Pressing on(double stiffness_N_m) {
  return Pressing(Forecast(frame(), ForceBound({}, stiffness_N_m), {}), frame());
}

Pressing::State standing_at(double travel_m) {
  Pressing::State now;
  now.limits.force_min_N = -0.2;
  now.limits.force_max_N = now.force_max_N = 1.5;
  now.travel_m = travel_m;
  now.force_N = 0.01;
  now.noise_N = 0.002;
  return now;
}

TEST(Pressing, WhatMayEndBeyondTheLimitIsRefusedWithTheSpeedThatMay) {
  const Pressing pressing = on(120e3);
  const auto no = pressing.to_force(standing_at(0), 0.5, 1e-3);
  ASSERT_FALSE(no);
  EXPECT_EQ(no.error().code, Errc::invalid_request);
  EXPECT_THAT(no.error().what, HasSubstr("the limit is 1.5 N: at most 0.8"));
  const auto yes = pressing.to_force(standing_at(0), 0.5, 0.8e-3);
  ASSERT_TRUE(yes) << yes.error().what;
  EXPECT_LE(yes->worst_N, 1.5);
  EXPECT_EQ(yes->limits.force_max, 1.5_N);
  EXPECT_LT(yes->guard.si(), 60e-3) << "a stop for want of travel needs its way";
}

TEST(Pressing, TowardsASpecimenThatMayBeAnywhereTheDeviceStopsEarly) {
  const Pressing pressing = on(120e3);
  const auto slow = pressing.to_travel(standing_at(10e-3), 20e-3, 0.5e-3);
  ASSERT_TRUE(slow) << slow.error().what;
  const double trip_N = slow->limits.force_max.si();
  EXPECT_NEAR(trip_N + 120e3 * stopping_way_m(frame(), 0.5e-3), 1.5, 1e-9);
  EXPECT_FALSE(pressing.to_travel(standing_at(10e-3), 20e-3, 5e-3));
  EXPECT_TRUE(pressing.to_travel(standing_at(10e-3), 5e-3, 5e-3)) << "away from it";
}

TEST(Pressing, WhereContactIsKnownTheAirIsFree) {
  const Pressing pressing = on(120e3);
  Pressing::State now = standing_at(10e-3);
  now.contact_m = 30e-3;
  now.contact_N = 0.05;
  const auto air = pressing.to_travel(now, 29.9e-3, 5e-3);
  ASSERT_TRUE(air) << air.error().what;
  EXPECT_EQ(air->limits.force_max, 1.5_N);
  EXPECT_FALSE(pressing.to_travel(now, 30.1e-3, 5e-3));
  const auto in = pressing.to_travel(now, 30.005e-3, 5e-3);
  ASSERT_TRUE(in) << "5 um at 120 N/mm are 0.6 N, however fast: " << in.error().what;
  EXPECT_NEAR(in->worst_N, 0.65, 1e-6);
}

TEST(Pressing, CountsFromWhatTheUnloadedCellShows) {
  const Pressing pressing = on(120e3);
  Pressing::State now = standing_at(0);
  now.rest_N = 0.3;
  const auto permit = pressing.to_force(now, 0.35, 0.1e-3);
  ASSERT_TRUE(permit);
  EXPECT_NEAR(permit->worst_N, 0.35 + 120e3 * stopping_way_m(frame(), 0.1e-3), 1e-9);
}

MotionOutcome target(double force_N) {
  MotionOutcome o;
  o.force_N = force_N;
  return o;
}

TEST(Pressing, APredictionThatWasExceededIsTheLastOne) {
  Pressing pressing = on(120e3);
  const auto permit = pressing.to_force(standing_at(0), 0.5, 0.1e-3);
  ASSERT_TRUE(permit);
  pressing.begin(*permit);
  const auto good = pressing.end(target(permit->worst_N), 0.002);
  ASSERT_TRUE(good);
  EXPECT_FALSE(good->exceeded);
  EXPECT_TRUE(pressing.to_force(standing_at(0), 0.5, 0.1e-3));

  pressing.begin(*permit);
  FrameSample high;
  high.force_N = permit->worst_N + 0.1;
  pressing.add({&high, 1});
  const auto bad = pressing.end(target(0.5), 0.002);
  ASSERT_TRUE(bad);
  EXPECT_TRUE(bad->exceeded);
  const auto no = pressing.to_force(standing_at(0), 0.5, 0.01e-3);
  ASSERT_FALSE(no);
  EXPECT_EQ(no.error().code, Errc::limit_tripped);
  EXPECT_THAT(no.error().what, HasSubstr("nothing is pressed any more"));
  EXPECT_TRUE(pressing.to_travel(standing_at(10e-3), 5e-3, 1e-3)) << "away is always allowed";
}

// A cell may show as much more than the prediction as its class allows, and no more.
TEST(Pressing, ACellIsJudgedByItsOwnClass) {
  for (const double percent : kForceClasses) {
    const auto exceeds = [percent](double part) {
      FrameCapabilities caps = frame();
      caps.force_class = ForceClass(percent);
      Pressing pressing(Forecast(caps, ForceBound({}, 120e3), {}), caps);
      const auto permit = pressing.to_force(standing_at(0), 0.5, 0.1e-3).value();
      pressing.begin(permit);
      return pressing.end(target(permit.worst_N * (1 + part)), 0)->exceeded;
    };
    EXPECT_FALSE(exceeds(0.99 * percent / 100)) << percent;
    EXPECT_TRUE(exceeds(1.01 * percent / 100)) << percent;
  }
}

// A tenth of the class, of the nominal force, is what its zero may err.
TEST(Pressing, TheLeastForceToStopAtIsBeyondTheZeroOfTheCell) {
  FrameCapabilities caps = frame();
  EXPECT_DOUBLE_EQ(least_trip_N(caps, 0), 0.02) << "class 1 is assumed";
  for (const double percent : kForceClasses) {
    caps.force_class = ForceClass(percent);
    EXPECT_DOUBLE_EQ(least_trip_N(caps, 0), 20 * percent / 1000);
  }
}

FrameSample shown(double force_N, Duration at) {
  FrameSample s;
  s.force_N = force_N;
  s.received = MonoTime() + at;
  return s;
}

// The cell has a filter, and DONE comes before it has followed.
class ShownLate : public testing::Test {
 protected:
  ShownLate() {
    permit_ = pressing_.to_force(standing_at(0), 0.5, 0.1e-3).value();
    pressing_.begin(permit_);
    EXPECT_FALSE(pressing_.end(target(0.51), 0.002).value().exceeded);
  }
  std::optional<Pressing::Comparison> show(double force_N, Duration at) {
    const FrameSample s = shown(force_N, at);
    return pressing_.add({&s, 1});
  }
  Pressing pressing_ = on(120e3);
  Pressing::Permit permit_;
};

TEST_F(ShownLate, AForceBeyondThePredictionBreaksIt) {
  EXPECT_FALSE(show(0.55, 10ms));
  const auto late = show(permit_.worst_N + 0.1, 60ms);
  ASSERT_TRUE(late);
  EXPECT_TRUE(late->exceeded);
  EXPECT_EQ(late->observed_N, permit_.worst_N + 0.1);
  EXPECT_TRUE(pressing_.broken());
  EXPECT_FALSE(show(permit_.worst_N + 0.2, 80ms)) << "told once";
}

TEST_F(ShownLate, AForceWithinThePredictionIsToldWhenTheFilterIsOver) {
  pressing_.begin(pressing_.away(standing_at(0)));
  EXPECT_FALSE(show(0.51, 10ms));
  EXPECT_FALSE(show(permit_.worst_N, 60ms));
  const auto late = show(0.1, 500ms);
  ASSERT_TRUE(late);
  EXPECT_FALSE(late->exceeded);
  EXPECT_EQ(late->observed_N, permit_.worst_N);
  EXPECT_FALSE(pressing_.broken());
}

TEST_F(ShownLate, NothingIsToldOfNoiseNorOfLaterForces) {
  EXPECT_FALSE(show(0.515, 10ms));
  EXPECT_FALSE(show(permit_.worst_N + 0.1, 500ms));
  EXPECT_FALSE(show(0.1, 600ms));
  EXPECT_FALSE(pressing_.broken());
}

TEST_F(ShownLate, WhatIsStillToBeShownBreaksNoPredictionOfTheNextMotion) {
  pressing_.begin(pressing_.to_force(standing_at(0), 0.52, 1e-6).value());
  EXPECT_FALSE(show(permit_.worst_N, 60ms));
  EXPECT_FALSE(pressing_.end(target(0.52), 0.002).value().exceeded);
}

TEST_F(ShownLate, TheNextMotionThatPressesEndsIt) {
  pressing_.begin(permit_);
  EXPECT_FALSE(show(permit_.worst_N + 0.1, 60ms));
  EXPECT_FALSE(pressing_.broken()) << "it is judged at its own end";
}

TEST(Pressing, AForceLoopThatNobodyDescribedIsNotUsed) {
  const Pressing pressing = on(120e3);
  EXPECT_FALSE(pressing.ramp(standing_at(0), 1, 0.1));
  EXPECT_TRUE(pressing.ramp(standing_at(0), 0, 0.1)) << "less force";
}

// The device's limit ended the motion. That it was needed shows that the prediction was wrong.
TEST(Pressing, AForceLimitThatCutAMotionShortCountsAsExceeded) {
  Pressing pressing = on(120e3);
  const auto permit = pressing.to_force(standing_at(0), 0.5, 0.1e-3);
  ASSERT_TRUE(permit);
  pressing.begin(*permit);
  MotionOutcome cut = target(1.6);
  cut.reason = MotionEnd::force_limit;
  const auto seen = pressing.end(cut, 0.002);
  ASSERT_TRUE(seen);
  EXPECT_TRUE(seen->exceeded);
  EXPECT_TRUE(pressing.broken());
}

TEST(Pressing, AWayIntoTheSpecimenIsComparedToo) {
  Pressing pressing = on(50e3);
  Pressing::State now = standing_at(9.9e-3);
  now.contact_m = 10e-3;
  now.contact_N = 0.1;
  const auto permit = pressing.to_travel(now, 10.005e-3, 0.1e-3);
  ASSERT_TRUE(permit) << permit.error().what;
  EXPECT_NEAR(permit->worst_N, 0.1 + 50e3 * 5e-6, 1e-9);
  pressing.begin(*permit);
  EXPECT_FALSE(pressing.end(target(0.34), 0.002)) << "as predicted: nothing to tell";
  pressing.begin(*permit);
  EXPECT_TRUE(pressing.end(target(0.74), 0.002));
  EXPECT_TRUE(pressing.broken());
}

}  // namespace
}  // namespace lcrig
