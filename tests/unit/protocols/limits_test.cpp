// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/limits.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "protocols/file/parse.hpp"
#include "tests/support/watched_frame.hpp"

namespace lcrig {
namespace {

using ::testing::HasSubstr;

// What the frame watches by itself: the narrower of protocol and machine.
TEST(Limits, OfTheFrameAreThoseOfTheProtocolWithinTheMachine) {
  FrameCapabilities caps = watched_capabilities();  // 0 to 60 mm, 10 mm/s
  BoundLimits limits;
  limits.force_min_N = -0.2;
  limits.force_max_N = 1;
  const FrameLimits wide = device_limits(limits, caps);
  EXPECT_DOUBLE_EQ(wide.travel_min.si(), 0);
  EXPECT_DOUBLE_EQ(wide.travel_max.si(), 60e-3);
  EXPECT_DOUBLE_EQ(wide.speed_max.si(), 10e-3);
  EXPECT_DOUBLE_EQ(wide.force_min.si(), -0.2);
  EXPECT_DOUBLE_EQ(wide.force_max.si(), 1);
  limits.travel_min_m = 5e-3;
  limits.travel_max_m = 70e-3;
  limits.speed_max_m_s = 2e-3;
  const FrameLimits narrow = device_limits(limits, caps);
  EXPECT_DOUBLE_EQ(narrow.travel_min.si(), 5e-3);
  EXPECT_DOUBLE_EQ(narrow.travel_max.si(), 60e-3);
  EXPECT_DOUBLE_EQ(narrow.speed_max.si(), 2e-3);
  limits.speed_max_m_s = 20e-3;
  EXPECT_DOUBLE_EQ(device_limits(limits, caps).speed_max.si(), 10e-3);
  limits.travel_min_m = -5e-3;
  EXPECT_DOUBLE_EQ(device_limits(limits, caps).travel_min.si(), 0);
}

// A limit is exceeded by more than rounding: 1e-9 of it, and near 0 of a micronewton.
TEST(Limits, RoundingExceedsNothing) {
  EXPECT_FALSE(exceeds(2 * (1 + 0.9e-9), 2));
  EXPECT_TRUE(exceeds(2 * (1 + 1.1e-9), 2));
  EXPECT_FALSE(exceeds(0.9e-15, 0));
  EXPECT_TRUE(exceeds(1.1e-15, 0));
}

TEST(Limits, ATripIsAtLeastWhatNoiseAndZeroOfTheCellShow) {
  const FrameCapabilities caps = watched_capabilities();
  EXPECT_DOUBLE_EQ(least_trip_N(caps, 1), 6);
  EXPECT_DOUBLE_EQ(least_trip_N(caps, 0), caps.cell().zero_error_N(20));
  EXPECT_DOUBLE_EQ(largest_end_N(2, 0.1), 2 - 6.25 * 0.1);
}

TEST(Limits, OfAGapCountFromTheContactAndNeverWidenThoseOfTheTravel) {
  BoundLimits limits;
  limits.gap_min_m = -20e-6;
  limits.gap_max_m = 1e-3;
  limits.place_contact(5e-3);
  EXPECT_DOUBLE_EQ(limits.travel_max_m.value(), 5.02e-3);
  EXPECT_DOUBLE_EQ(limits.travel_min_m.value(), 4e-3);
  limits.place_contact(5.01e-3);
  EXPECT_DOUBLE_EQ(limits.travel_max_m.value(), 5.02e-3) << "narrower";
  EXPECT_DOUBLE_EQ(limits.travel_min_m.value(), 4.01e-3);
  limits.place_contact(4.9e-3);
  EXPECT_DOUBLE_EQ(limits.travel_max_m.value(), 4.92e-3);
  EXPECT_DOUBLE_EQ(limits.travel_min_m.value(), 4.01e-3) << "narrower";
}

TEST(Limits, OfTheTravelMoveWithItsZero) {
  BoundLimits limits;
  limits.zero_travel(1e-3);
  EXPECT_FALSE(limits.travel_min_m);
  limits.travel_min_m = 1e-3;
  limits.travel_max_m = 3e-3;
  limits.zero_travel(2e-3);
  EXPECT_DOUBLE_EQ(*limits.travel_min_m, -1e-3);
  EXPECT_DOUBLE_EQ(*limits.travel_max_m, 1e-3);
}

TEST(Limits, TheWrongWayRoundAreRefusedWithTheirValues) {
  const auto bound = [](Limits limits) {
    Protocol protocol;
    protocol.name = "p";
    protocol.limits = std::move(limits);
    return bind_limits(protocol, Environment(), watched_capabilities());
  };
  Limits travel, gap, force;
  travel.travel_min = Number(3e-3);
  travel.travel_max = Number(2e-3);
  EXPECT_THAT(bound(travel).error().what, HasSubstr("travel from 3 to 2 mm"));
  gap.gap_min = Number(3e-3);
  gap.gap_max = Number(2e-3);
  EXPECT_THAT(bound(gap).error().what, HasSubstr("gap from 3 to 2 mm"));
  force.force_min = Number(3);
  force.force_max = Number(2);
  EXPECT_THAT(bound(force).error().what, HasSubstr("force from 3 to 2 N"));
}

}  // namespace
}  // namespace lcrig
