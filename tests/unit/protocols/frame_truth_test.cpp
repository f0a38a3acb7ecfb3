// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/frame_truth.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <random>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class Truth : public RunFixture {
 protected:
  FrameWatch& watch() { return parts().watch; }
  const FrameTruth& truth() { return parts().truth; }
  Plausibility::Motion motion_now(double direction, double speed_m_s) {
    return truth().motion_now(direction, speed_m_s, parts().view.shown_force());
  }
  Result<> believe(const MotionOrder& order, const MotionOutcome& outcome) {
    return run(parts().motions.believe(order, outcome));
  }
  // Thirty samples, ten a second, that alternate between the two forces.
  static Rest rest_between(double low_N, double high_N) {
    Rest rest;
    for (int i = 0; i < 30; ++i) {
      FrameSample s;
      s.received = MonoTime(i * 100ms);
      s.force_N = i % 2 == 0 ? low_N : high_N;
      s.travel_m = 0;
      rest.add(std::span(&s, 1));
    }
    return rest;
  }
  static MotionOrder to_travel(double travel_m) {
    MotionOrder order;
    order.travel_m = travel_m;
    return order;
  }
  static MotionOutcome done_at(double travel_m, double force_N) {
    MotionOutcome outcome;
    outcome.reason = MotionEnd::target;
    outcome.travel_m = travel_m;
    outcome.force_N = force_N;
    return outcome;
  }
};

TEST_F(Truth, NothingIsPressedBeforeTheCellWasSeenAlive) {
  EXPECT_TRUE(truth().needs_look());
  watch().learn_rest(rest_between(0.010, 0.012));
  EXPECT_FALSE(truth().needs_look());
  EXPECT_NEAR(truth().rest_N(), 0.011, 1e-12);
}

TEST_F(Truth, ACellThatHasFrozenTeachesNothing) {
  watch().learn_rest(rest_between(0.010, 0.012));
  watch().learn_rest(rest_between(0.5, 0.5));
  EXPECT_NEAR(truth().rest_N(), 0.011, 1e-12);
}

// Later the frame may creep, and creep must not count as noise.
TEST_F(Truth, HowTheTravelScattersIsLearnedAtTheFirstLook) {
  const auto look = [](double scatter_m) {
    Rest rest;
    for (int i = 0; i < 30; ++i) {
      FrameSample s;
      s.received = MonoTime(i * 100ms);
      s.force_N = i % 2 == 0 ? 0.010 : 0.012;
      s.travel_m = scatter_m * (i % 3 - 1);
      rest.add(std::span(&s, 1));
    }
    return rest;
  };
  const auto told_mm = [this] {
    return nlohmann::json::parse(sink.events.back().detail).at("travel_noise_mm").get<double>();
  };
  watch().learn_rest(look(2e-6));
  EXPECT_NEAR(told_mm(), 1.6e-3, 0.1e-3);
  watch().learn_rest(look(20e-6));
  EXPECT_NEAR(told_mm(), 1.6e-3, 0.1e-3);
}

// In the last look 18 samples of a cell that scatters by 16 mN scattered by less than a half of
// that.
TEST_F(Truth, ALookThatSeesTooLittleScatterMakesNoCellALiar) {
  std::mt19937 random(55);
  const auto look = [&random](double noise_N, int count) {
    std::normal_distribution<double> noise(0, noise_N);
    Rest rest;
    for (int i = 0; i < count; ++i) {
      FrameSample s;
      s.received = MonoTime(i * 20ms);
      s.force_N = std::round(noise(random) / 1e-4) * 1e-4;
      s.travel_m = 0;
      rest.add(std::span(&s, 1));
    }
    return rest;
  };
  for (const int count : {20, 25, 25}) watch().learn_rest(look(0.016, count));
  watch().learn_rest(look(0.0067, 18));
  EXPECT_GT(truth().sure_noise_N(), 0.013);
  EXPECT_LT(truth().sure_noise_N(), 0.024);
  parts().view.take_standstill(done_at(0, 0));
  EXPECT_GT(motion_now(1, 1e-5).against_N, kDifferenceSigmas * 0.013);
  EXPECT_LT(motion_now(1, 1e-5).against_N, 0.25);
}

TEST_F(Truth, ARestThatMayTouchIsNotTheBareCell) {
  watch().learn_rest(rest_between(0.010, 0.012));
  watch().learn_rest(rest_between(0.110, 0.112), FrameTruth::Under::perhaps_contact);
  EXPECT_NEAR(truth().rest_N(), 0.111, 1e-12);
  EXPECT_NEAR(truth().bare_N(), 0.011, 1e-12);
  EXPECT_TRUE(truth().is_loaded(0.2));
  EXPECT_FALSE(truth().is_loaded(0.012));
}

TEST_F(Truth, ASpecimenThatMayHavePulledIsNotTakenForOneThatPressesNow) {
  watch().learn_rest(rest_between(-0.046, -0.044));
  EXPECT_TRUE(truth().is_loaded(0));
  watch().learn_unpulled(0.001);
  EXPECT_FALSE(truth().is_loaded(0));
  EXPECT_TRUE(truth().is_loaded(0.02));
  EXPECT_FALSE(truth().is_pulled(-0.06));
  EXPECT_TRUE(truth().is_pulled(-0.1));
  watch().learn_rest(rest_between(-0.046, -0.044));
  EXPECT_TRUE(truth().is_loaded(0)) << "a new look counts alone";
}

TEST_F(Truth, TheZeroOfTheCellMayErrByATenthOfItsClass) {
  for (const double percent : kForceClasses) {
    WatchedRig rig = watch().rig();
    rig.cell = ForceClass(percent);
    const FrameTruth of_class(rig, parts().guard, nullptr, {});
    EXPECT_DOUBLE_EQ(of_class.zero_doubt_N(), rig.frame.force_max.si() * percent / 1000);
  }
}

TEST_F(Truth, AMotionThatEndedWhereItShouldIsBelieved) {
  watch().learn_rest(rest_between(0.010, 0.012));
  show(0.011, 1e-3);
  EXPECT_TRUE(believe(to_travel(1e-3), done_at(1e-3, 0.011)));
  EXPECT_EQ(events_of("contradiction"), 0);
}

TEST_F(Truth, ADoneElsewhereIsRefusedAndRecorded) {
  watch().learn_rest(rest_between(0.010, 0.012));
  show(0.011, 0.4e-3);
  const auto r = believe(to_travel(1e-3), done_at(1e-3, 0.011));
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::refused);
  EXPECT_THAT(r.error().what, HasSubstr("it was to go to 1.0000 mm, and shows 0.4000 mm"));
  EXPECT_EQ(events_of("contradiction"), 1);
}

// The last sample is older than the frame's message; the next one may confirm it.
TEST_F(Truth, TheSamplesMayComeLater) {
  watch().learn_rest(rest_between(0.010, 0.012));
  show(0.011, 0.9e-3);
  auto late = [](Clock& time, std::function<void()> act) -> Task<> {
    co_await time.wait_for(50ms);
    act();
  };
  bool ended = false;
  start(late(clock, [this] { show(0.011, 1e-3); }), ended);
  EXPECT_TRUE(believe(to_travel(1e-3), done_at(1e-3, 0.011)));
  EXPECT_TRUE(ended);
}

TEST_F(Truth, AMotionThatDidNotReachItsTargetIsNotJudged) {
  watch().learn_rest(rest_between(0.010, 0.012));
  show(0.011, 0.4e-3);
  MotionOutcome stopped = done_at(0.4e-3, 0.011);
  stopped.reason = MotionEnd::stopped;
  EXPECT_TRUE(believe(to_travel(1e-3), stopped));
}

// The relaxation that a specimen is allowed grows with the force that is felt.
TEST_F(Truth, ALoadedMotionIsAllowedMoreThanAnUnloadedOne) {
  watch().learn_rest(rest_between(0.010, 0.012));
  show(0.011, 0);
  const double bare_N = motion_now(1, 1e-5).against_N;
  show(0.611, 0);
  const double loaded_N = motion_now(1, 1e-5).against_N;
  EXPECT_GT(loaded_N, bare_N + 0.05);
  EXPECT_LT(motion_now(-1, 1e-5).against_N, loaded_N);
}

// The force before an overload says nothing about the way back from the overload.
TEST_F(Truth, OnTheWayBackFromAnOverloadTheForceMayBeAsHighAsItIs) {
  watch().learn_rest(rest_between(0.010, 0.012));
  show(0.5, 1e-3);
  FrameSample dark = frame.sample();
  dark.force_N.reset();
  dark.flags = frame_flag::kForceOverload;
  parts().view.add(std::span(&dark, 1));
  EXPECT_TRUE(motion_now(1, 1e-5).force_known) << "towards the specimen nothing is excused";
  watch().order(motion_now(-1, 1e-5));
  const auto check = [this](double force_N, double travel_m) {
    show(force_N, travel_m);
    return watch().check(frame.sample());
  };
  EXPECT_FALSE(check(4.6, 0.9e-3));
  EXPECT_FALSE(check(3.0, 0.8e-3));
  EXPECT_TRUE(check(5.2, 0.7e-3)) << "now it rises";
}

TEST_F(Truth, AFrameThatThisRunDoesNotMoveIsBelieved) {
  setup().commands = false;
  EXPECT_FALSE(truth().needs_look());
  show(0.011, 0.4e-3);
  EXPECT_TRUE(believe(to_travel(1e-3), done_at(1e-3, 0.011)));
}

}  // namespace
}  // namespace lcrig
