// SPDX-License-Identifier: Apache-2.0
// The place of contact, and the search for it.
#include <gmock/gmock.h>

#include "protocols/contact/contact_search.hpp"
#include "protocols/steps/find_contact.hpp"
#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

constexpr double kContact_m = 5e-3, kStiffness_N_m = 1e4, kThreshold_N = 0.02;

class FindsContact : public RunFixture {
 protected:
  FindsContact() {
    frame.noise_N = 1e-4;
    frame.travel_m = 4.9e-3;
    find.speed = Number(1e-5);
    find.force = Number(kThreshold_N);
    find.back_off = Number(1e-3);
    find.timeout = Number(300);
    feed();
    parts().log.begin_step(step(0));
  }
  Result<> search() {
    ContactSearch search(parts(), find);
    return run(search.find(progress.start_travel_m));
  }
  static double specimen(double travel_m) {
    return kStiffness_N_m * std::max(0.0, travel_m - kContact_m);
  }

  FindContactStep find;
  FindContactStep::Progress progress;
};

TEST_F(FindsContact, IsFoundWhereTheSpecimenIs) {
  frame.force_at = specimen;
  const auto found = search();
  ASSERT_TRUE(found) << found.error().what;
  EXPECT_NEAR(*parts().rig.contact.travel_m, kContact_m + kThreshold_N / kStiffness_N_m, 1e-6);
  EXPECT_NEAR(frame.travel_m, *parts().rig.contact.travel_m - 1e-3, 1e-9) << "and it backed off";
  EXPECT_EQ(events_of("contact"), 1);
  EXPECT_EQ(events_of("stiffness"), 1);
  EXPECT_FALSE(parts().rig.contact.searched_from_m);
}

// The threshold lies 1 mm inside the specimen, and the way back ends there.
TEST_F(FindsContact, IsRefusedWhereTheWayBackStillPresses) {
  frame.force_at = [](double travel_m) { return 0.05 * specimen(travel_m); };
  find.force = Number(0.5);
  find.back_off = Number(0.2e-3);
  const double rest_N = parts().rig.cell.unloaded_N();
  const auto found = search();
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().what, HasSubstr("back_off_mm is too small"));
  EXPECT_THAT(found.error().what, HasSubstr("still presses with about 0.4 N"));
  EXPECT_NEAR(parts().rig.cell.unloaded_N(), rest_N, 1e-3) << "it learns no zero there";
  EXPECT_GE(parts().rig.contact.depth_m, 1e-3);
}

// The way back ends while it still pulls with 45 mN, which lies within the place of contact.
TEST_F(FindsContact, WithASpecimenThatSticksLeavesTheCellUnloadedOnceItLetsGo) {
  frame.force_at = [](double travel_m) {
    static constexpr double kSticks_m = 0.2e-3;
    const bool sticks = travel_m < kContact_m && travel_m > kContact_m - kSticks_m;
    return sticks ? -0.045 : specimen(travel_m);
  };
  frame.travel_m = 4e-3;
  find.back_off = Number(0.05e-3);
  const auto found = search();
  ASSERT_TRUE(found) << found.error().what;
  const RigState& rig = parts().rig;
  EXPECT_NEAR(rig.cell.unloaded_N(), -0.045, 1e-3);
  EXPECT_FALSE(rig.is_loaded(0));
  EXPECT_FALSE(rig.is_pulled(-0.045));
  EXPECT_TRUE(rig.is_loaded(0.02));
  EXPECT_TRUE(rig.is_pulled(-0.1));
  EXPECT_NEAR(rig.order_now(-1, 1e-5, 0).free_N.value(), 0, 1e-3);
}

TEST_F(FindsContact, IsNoneWhereTheForceStaysOnTheWayBack) {
  double shown_N = 0;
  frame.force_at = [&](double travel_m) { return shown_N = std::max(shown_N, specimen(travel_m)); };
  const auto found = search();
  ASSERT_FALSE(found);
  EXPECT_FALSE(parts().rig.contact.travel_m);
  EXPECT_GT(events_of("no_contact"), 0);
  EXPECT_DOUBLE_EQ(*parts().rig.contact.searched_from_m, 4.9e-3) << "`finally` goes back there";
}

// It shows the travel that was ordered, and the cell shows the force too late for a check in
// motion.
TEST_F(FindsContact, OfADriveThatPressesOnTwoWaysBackIsNotBelievedAndNothingMovesAnyMore) {
  double last_m = 0, deeper_m = 0, largest_N = 0;
  frame.force_at = [&](double travel_m) {
    deeper_m += 2 * std::max(0.0, last_m - travel_m);
    last_m = travel_m;
    const double true_N = specimen(travel_m + deeper_m);
    largest_N = std::max(largest_N, true_N);
    return true_N;
  };
  const auto found = search();
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().what, HasSubstr("the force rises against the command"));
  ASSERT_TRUE(parts().drive.hands_off());
  EXPECT_TRUE(found.error().hands_off);
  EXPECT_EQ(events_of("no_contact"), 2);
  EXPECT_EQ(events_of("contradiction"), 1);
  EXPECT_LT(largest_N, 4 * kThreshold_N);
}

TEST_F(FindsContact, IsNotSearchedWhereTheProbeTouchesAlready) {
  frame.force_N = 0.1;
  const auto found = search();
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().what, HasSubstr("the probe touches already"));
}

TEST_F(FindsContact, IsNotSearchedWithACellThatScattersMoreThanTheThreshold) {
  frame.noise_N = 0.05;
  EXPECT_EQ(search().error().code, Errc::invalid_request);
}

TEST_F(FindsContact, IsWhereAGapIsCountedFrom) {
  Target gap;
  gap.kind = TargetKind::gap;
  gap.value = Number(1e-3);
  EXPECT_EQ(travel_of(gap, parts()).error().code, Errc::invalid_request);
  parts().watch.place_contact(kContact_m, 0);
  EXPECT_DOUBLE_EQ(travel_of(gap, parts()).value(), kContact_m - 1e-3);
}

}  // namespace
}  // namespace lcrig
