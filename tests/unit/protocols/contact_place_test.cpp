// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

class ContactPlaces : public RunFixture {
 protected:
  Result<double> travel_of(TargetKind kind, double value) {
    Target target;
    target.kind = kind;
    target.value = Number(value);
    return lcrig::travel_of(target, parts());
  }
};

TEST_F(ContactPlaces, AGapCountsFromContactAndIsPositiveWhenApart) {
  parts().watch.place_contact(10e-3, 0.02);
  EXPECT_DOUBLE_EQ(travel_of(TargetKind::gap, 2e-3).value(), 8e-3);
  EXPECT_DOUBLE_EQ(travel_of(TargetKind::gap, -1e-3).value(), 11e-3);
  EXPECT_DOUBLE_EQ(travel_of(TargetKind::travel, 2e-3).value(), 2e-3);
}

TEST_F(ContactPlaces, WithoutContactThereIsNoGap) {
  const auto travel = travel_of(TargetKind::gap, 2e-3);
  ASSERT_FALSE(travel);
  EXPECT_EQ(travel.error().code, Errc::invalid_request);
  EXPECT_NE(travel.error().what.find("set_gap"), std::string::npos) << "the other way to know it";
  EXPECT_TRUE(travel_of(TargetKind::travel, 2e-3));
}

TEST_F(ContactPlaces, ANewZeroForgetsContactAndMovesTheEndsOfTheMachine) {
  parts().watch.place_contact(10e-3, 0.02);
  for (const double travel_m : {4e-3, 1e-3}) {
    RestMeasurement rest;
    FrameSample sample = frame.sample();
    sample.travel_m = travel_m;
    rest.add(std::span(&sample, 1));
    parts().watch.zeroed(rest, false, true, 0);
  }
  EXPECT_FALSE(parts().rig.contact.travel_m);
  EXPECT_DOUBLE_EQ(parts().rig.frame.zero_m, 5e-3);
  EXPECT_NEAR(parts().rig.frame.caps.travel_max.si(), 55e-3, 1e-12);  // 60 before
  EXPECT_NEAR(parts().rig.frame.caps.travel_min.si(), -5e-3, 1e-12);
}

TEST_F(ContactPlaces, LimitsOfGapHoldFromContactOn) {
  setup().limits.gap_min_m = -1e-3;
  setup().limits.gap_max_m = 3e-3;
  parts().watch.place_contact(10e-3, 0.02);
  EXPECT_NEAR(*parts().rig.limits.travel_min_m, 7e-3, 1e-12);
  EXPECT_NEAR(*parts().rig.limits.travel_max_m, 11e-3, 1e-12);
}

}  // namespace
}  // namespace lcrig
