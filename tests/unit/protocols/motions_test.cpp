// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/motions.hpp"

#include <gmock/gmock.h>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Motion : public RunFixture {
 protected:
  Motion() {
    frame.noise_N = 1e-4;
    frame.travel_m = 5e-3;
    feed();
    parts().log.begin_step(step(0));
    parts().watch.learn_zero(run(parts().meter.measure_alive()).value());
    sink.events.clear();
  }
  Result<> to_travel(double travel_m) { return run(parts().motions.to_travel(travel_m, 1e-3, 60)); }
};

TEST_F(Motion, ArmsTheDeviceThenMoves) {
  const auto moved = to_travel(1e-3);
  EXPECT_TRUE(moved) << moved.error().what;
  EXPECT_THAT(frame.commands, ElementsAre("arm", "move_to"));
  EXPECT_DOUBLE_EQ(*parts().rig.frame.seen.travel_m, 1e-3);
  EXPECT_EQ(sink.kinds().front(), "motion");
}

TEST_F(Motion, ThatDidNotEndWhereItWasToldToIsNotBelieved) {
  frame.motion_says.travel_m = 3e-3;
  const auto moved = to_travel(1e-3);
  ASSERT_FALSE(moved);
  EXPECT_THAT(moved.error().what, HasSubstr("step r: the frame says DONE, but that is not true"));
}

TEST_F(Motion, ThatStopsAtALimitFailsItsStep) {
  frame.motion_says.reason = MotionEnd::force_limit;
  EXPECT_EQ(to_travel(1e-3).error().code, Errc::limit_tripped);
  frame.motion_says.reason = MotionEnd::stopped;
  EXPECT_EQ(to_travel(1e-3).error().code, Errc::aborted);
  frame.motion_says.reason = MotionEnd::fault;
  EXPECT_EQ(to_travel(1e-3).error().code, Errc::refused);
}

TEST_F(Motion, ThatFailsIsToldInTheDevicesWordsIfItSaysAny) {
  frame.motion_says.reason = MotionEnd::force_limit;
  EXPECT_EQ(to_travel(1e-3).error().what, "step r: the frame stopped at its force limit");
  frame.motion_says.detail = "channel 2";
  EXPECT_EQ(to_travel(1e-3).error().what,
            "step r: the frame stopped at its force limit: channel 2");
}

TEST_F(Motion, ThatTheContactStoppedSaysSo) {
  frame.motion_says.reason = MotionEnd::travel_limit;
  EXPECT_EQ(run(parts().motions.to_force(0.1, 1e-5, 60)).error().what,
            "step r: the frame stopped at its travel limit");
  parts().watch.place_contact(5e-3, 0.02);
  parts().watch.know_least_stiffness(5e-3, 0.02, 1e4);
  EXPECT_THAT(run(parts().motions.to_force(0.1, 1e-5, 60)).error().what,
              HasSubstr("where the contact that was found must show 0.1 N at least"));
}

TEST_F(Motion, ThatNeverEndsFailsAfterItsTime) {
  frame.never_ends = true;
  const MonoTime begun = clock.now();
  EXPECT_EQ(to_travel(1e-3).error().code, Errc::no_reply);
  EXPECT_EQ(clock.now() - begun, 60s);
  EXPECT_FALSE(parts().motions.in_motion());
}

TEST_F(Motion, EndsAHold) {
  parts().drive.will_hold(0.5);
  EXPECT_TRUE(to_travel(1e-3));
  EXPECT_FALSE(parts().drive.held_force_N());
}

TEST_F(Motion, TowardsTheSpecimenIsSkippedOnceTheForceIsNotBelieved) {
  parts().watch.invalidate_force();
  EXPECT_TRUE(to_travel(6e-3));
  EXPECT_THAT(frame.commands, IsEmpty());
  EXPECT_THAT(sink.kinds(), ElementsAre("skipped"));
}

TEST_F(Motion, DoesNotBeginOnceHandsAreOff) {
  parts().drive.keep_hands_off("it lies");
  EXPECT_FALSE(to_travel(1e-3));
  EXPECT_FALSE(run(parts().motions.to_force(0.1, 1e-5, 60)));
  EXPECT_THAT(frame.commands, IsEmpty());
}

// A step whose facts are wrong.
TEST_F(Motion, OfAFrameThatIsOnlyObservedIsABug) {
  setup().commands = false;
  EXPECT_EQ(to_travel(1e-3).error().code, Errc::bug);
  EXPECT_EQ(run(parts().motions.to_force(0.1, 1e-5, 60)).error().code, Errc::bug);
  EXPECT_THAT(frame.commands, IsEmpty());
}

// At DONE the cell shows half of the force; its filter still follows, and the way away begins.
TEST_F(Motion, WhatTheCellShowsLateIsNoDriveThatDisobeys) {
  frame.motion_says.force_N = 0.3;
  frame.force_N = 0.3;
  const auto pressed = run(parts().motions.to_force(0.3, 1e-4, 60));
  ASSERT_TRUE(pressed) << pressed.error().what;
  const double worst_N = sink.events.back().as<OvershootEvent>()->predicted_N;
  const auto shows = [this](double force_N) {
    frame.force_N = force_N;
    return most_severe(parts().watch.add(frame.sample())) != nullptr;
  };
  parts().watch.order(parts().rig.order_now(-1, 1e-5, parts().meter.noise_N()));
  EXPECT_FALSE(shows(worst_N));
  EXPECT_TRUE(shows(worst_N + 0.1));
  EXPECT_GT(worst_N, 0.39) << "more than the tolerance of the way away";
}

TEST_F(Motion, ThatWouldPressTooHardIsRefusedBeforeAnythingMoves) {
  EXPECT_EQ(run(parts().motions.to_force(0.9, 0.01, 60)).error().code, Errc::invalid_request);
  EXPECT_THAT(frame.commands, IsEmpty());
}

}  // namespace
}  // namespace lcrig
