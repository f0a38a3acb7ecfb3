// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/permit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/watched_frame.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

// A frame that stands at this travel before a contact of this stiffness, with a limit of 1.5 N.
RigState standing_at(double travel_m, double stiffness_N_m = 120e3,
                     FrameCapabilities caps = watched_capabilities()) {
  RigFacts facts = watched_facts(caps);
  facts.limits.force_min_N = -0.2;
  facts.limits.force_max_N = 1.5;
  RigState rig(facts, watched_forecast(stiffness_N_m, caps));
  rig.frame.seen.travel_m = travel_m;
  rig.frame.force_N = 0.01;
  return rig;
}

TEST(Permit, WhatMayEndBeyondTheLimitIsRefusedWithTheSpeedThatMay) {
  const auto no = permit_to_force(standing_at(0), 0.5, 1e-3);
  ASSERT_FALSE(no);
  EXPECT_EQ(no.error().code, Errc::invalid_request);
  EXPECT_THAT(no.error().what, HasSubstr("the limit is 1.5 N: at most 0.8"));
  const auto yes = permit_to_force(standing_at(0), 0.5, 0.8e-3);
  ASSERT_TRUE(yes) << yes.error().what;
  EXPECT_LE(yes->worst_N, 1.5);
  EXPECT_EQ(yes->limits.force_max, 1.5_N);
  EXPECT_LT(yes->guard.si(), 60e-3) << "a stop for want of travel needs its way";
}

TEST(Permit, TowardsASpecimenThatMayBeAnywhereTheDeviceStopsEarly) {
  const auto slow = permit_to_travel(standing_at(10e-3), 20e-3, 0.5e-3);
  ASSERT_TRUE(slow) << slow.error().what;
  const double trip_N = slow->limits.force_max.si();
  EXPECT_NEAR(trip_N + 120e3 * stopping_way_m(watched_capabilities(), 0.5e-3), 1.5, 1e-9);
  EXPECT_FALSE(permit_to_travel(standing_at(10e-3), 20e-3, 5e-3));
  EXPECT_TRUE(permit_to_travel(standing_at(10e-3), 5e-3, 5e-3)) << "away from it";
}

TEST(Permit, WhereContactIsKnownTheAirIsFree) {
  RigState now = standing_at(10e-3);
  now.contact.travel_m = 30e-3;
  now.contact.force_N = 0.05;
  const auto air = permit_to_travel(now, 29.9e-3, 5e-3);
  ASSERT_TRUE(air) << air.error().what;
  EXPECT_EQ(air->limits.force_max, 1.5_N);
  EXPECT_FALSE(permit_to_travel(now, 30.1e-3, 5e-3));
  const auto in = permit_to_travel(now, 30.005e-3, 5e-3);
  ASSERT_TRUE(in) << "5 um at 120 N/mm are 0.6 N, however fast: " << in.error().what;
  EXPECT_NEAR(in->worst_N, 0.65, 1e-6);
}

TEST(Permit, CountsFromWhatTheUnloadedCellShows) {
  RigState now = standing_at(0);
  RestMeasurement zero;
  for (int i = 0; i < 2; ++i) {
    FrameSample sample;
    sample.force_N = 0.3;
    zero.add(std::span(&sample, 1));
  }
  now.cell.zero = zero;
  const auto permit = permit_to_force(now, 0.35, 0.1e-3);
  ASSERT_TRUE(permit);
  EXPECT_NEAR(permit->worst_N, 0.35 + 120e3 * stopping_way_m(watched_capabilities(), 0.1e-3), 1e-9);
  // Towards a specimen that may be anywhere: the device stops so early that 1.5 N are shown at
  // most.
  const auto blind = permit_to_travel(now, 20e-3, 0.1e-3);
  ASSERT_TRUE(blind) << blind.error().what;
  EXPECT_NEAR(blind->limits.force_max.si(),
              1.5 - 120e3 * stopping_way_m(watched_capabilities(), 0.1e-3), 1e-6);
}

// A tenth of the class, of the nominal force, is what its zero may err.
TEST(Permit, TheLeastForceToStopAtIsBeyondTheZeroOfTheCell) {
  FrameCapabilities caps = watched_capabilities();
  EXPECT_DOUBLE_EQ(least_trip_N(caps, 0), 0.02) << "class 1 is assumed";
  for (const double percent : kForceClasses) {
    caps.force_class = ForceClass(percent);
    EXPECT_DOUBLE_EQ(least_trip_N(caps, 0), 20 * percent / 1000);
  }
}

TEST(Permit, AForceLoopThatNobodyDescribedIsNotUsed) {
  EXPECT_FALSE(permit_ramp(standing_at(0), 1, 0.1));
  EXPECT_TRUE(permit_ramp(standing_at(0), 0, 0.1)) << "less force";
}

}  // namespace
}  // namespace lcrig
