// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/rig_state.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <random>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class State : public RunFixture {
 protected:
  FrameWatch& watch() { return parts().watch; }
  const RigState& rig() { return parts().rig; }
  Order motion_now(double direction, double speed_m_s) {
    return rig().order_now(direction, speed_m_s, parts().meter.noise_N());
  }
  Result<> confirm(const MotionOrder& order, const MotionOutcome& outcome) {
    return run(parts().motions.confirm_end(order, outcome));
  }
  // Thirty samples, ten a second, that alternate between the two forces.
  static RestMeasurement rest_between(double low_N, double high_N) {
    RestMeasurement rest;
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

TEST_F(State, NothingIsPressedBeforeTheCellWasSeenAlive) {
  EXPECT_TRUE(rig().needs_live_cell());
  watch().learn_zero(rest_between(0.010, 0.012));
  EXPECT_FALSE(rig().needs_live_cell());
  EXPECT_NEAR(rig().cell.zero_N(), 0.011, 1e-12);
}

TEST_F(State, ACellThatHasFrozenTeachesNothing) {
  watch().learn_zero(rest_between(0.010, 0.012));
  watch().learn_zero(rest_between(0.5, 0.5));
  EXPECT_NEAR(rig().cell.zero_N(), 0.011, 1e-12);
}

// Later the frame may creep, and creep must not count as noise.
TEST_F(State, HowTheTravelScattersIsLearnedAtTheFirstLook) {
  const auto look = [](double scatter_m) {
    RestMeasurement rest;
    for (int i = 0; i < 30; ++i) {
      FrameSample s;
      s.received = MonoTime(i * 100ms);
      s.force_N = i % 2 == 0 ? 0.010 : 0.012;
      s.travel_m = scatter_m * (i % 3 - 1);
      rest.add(std::span(&s, 1));
    }
    return rest;
  };
  const auto travel_noise_mm = [this] { return rig().tolerances.travel_noise_m * 1e3; };
  watch().learn_zero(look(2e-6));
  EXPECT_NEAR(travel_noise_mm(), 1.6e-3, 0.1e-3);
  watch().learn_zero(look(20e-6));
  EXPECT_NEAR(travel_noise_mm(), 1.6e-3, 0.1e-3);
}

// In the last look 18 samples of a cell that scatters by 16 mN scattered by less than a half of
// that.
TEST_F(State, ALookThatSeesTooLittleScatterMakesNoCellALiar) {
  std::mt19937 random(55);
  const auto look = [&random](double noise_N, int count) {
    std::normal_distribution<double> noise(0, noise_N);
    RestMeasurement rest;
    for (int i = 0; i < count; ++i) {
      FrameSample s;
      s.received = MonoTime(i * 20ms);
      s.force_N = std::round(noise(random) / 1e-4) * 1e-4;
      s.travel_m = 0;
      rest.add(std::span(&s, 1));
    }
    return rest;
  };
  for (const int count : {20, 25, 25}) watch().learn_zero(look(0.016, count));
  watch().learn_zero(look(0.0067, 18));
  EXPECT_GT(rig().cell.noise_bound_N(), 0.013);
  EXPECT_LT(rig().cell.noise_bound_N(), 0.024);
  watch().motion_stood(done_at(0, 0));
  EXPECT_GT(motion_now(1, 1e-5).against_N, kDifferenceSigmas * 0.013);
  EXPECT_LT(motion_now(1, 1e-5).against_N, 0.25);
}

// Digits of 0.1 mN: the more a cell scatters, the fewer equal ones follow each other.
TEST_F(State, APromiseToNoticeAFrozenCellIsKeptOrBettered) {
  const auto look = [](double amplitude_N) {
    RestMeasurement rest;
    for (int i = 0; i < 40; ++i) {
      FrameSample s;
      s.received = MonoTime(i * 20ms);
      s.force_N = 1e-4 * std::round(amplitude_N * 1e4 * std::sin(i));
      s.travel_m = 0;
      rest.add(std::span(&s, 1));
    }
    return rest;
  };
  watch().learn_zero(look(2e-4));
  const auto first = rig().tolerances.frozen_samples;
  ASSERT_TRUE(first);
  watch().learn_noise(look(5e-3));
  const auto better = rig().tolerances.frozen_samples;
  ASSERT_TRUE(better);
  EXPECT_LT(*better, *first);
  watch().learn_noise(look(2e-4));
  EXPECT_EQ(rig().tolerances.frozen_samples, better);
}

TEST_F(State, ARestThatMayTouchIsNotTheBareCell) {
  watch().learn_zero(rest_between(0.010, 0.012));
  watch().learn_zero(rest_between(0.110, 0.112), FrameWatch::Under::perhaps_contact);
  EXPECT_NEAR(rig().cell.zero_N(), 0.111, 1e-12);
  EXPECT_NEAR(rig().cell.unloaded_N(), 0.011, 1e-12);
  EXPECT_TRUE(rig().is_loaded(0.2));
  EXPECT_FALSE(rig().is_loaded(0.012));
}

TEST_F(State, ASpecimenThatMayHavePulledIsNotTakenForOneThatPressesNow) {
  watch().learn_zero(rest_between(-0.046, -0.044));
  EXPECT_TRUE(rig().is_loaded(0));
  watch().learn_untouched(0.001);
  EXPECT_FALSE(rig().is_loaded(0));
  EXPECT_TRUE(rig().is_loaded(0.02));
  EXPECT_FALSE(rig().is_pulled(-0.06));
  EXPECT_TRUE(rig().is_pulled(-0.1));
  watch().learn_zero(rest_between(-0.046, -0.044));
  EXPECT_TRUE(rig().is_loaded(0)) << "a new look counts alone";
}

TEST_F(State, TheZeroOfTheCellMayErrByATenthOfItsClass) {
  for (const double percent : kForceClasses) {
    RigFacts facts = rig().facts;
    facts.cell = ForceClass(percent);
    const RigState of_class(facts, std::nullopt);
    EXPECT_DOUBLE_EQ(of_class.zero_uncertainty_N(), facts.frame.force_max.si() * percent / 1000);
  }
}

TEST_F(State, AMotionThatEndedWhereItShouldIsBelieved) {
  watch().learn_zero(rest_between(0.010, 0.012));
  show(0.011, 1e-3);
  EXPECT_TRUE(confirm(to_travel(1e-3), done_at(1e-3, 0.011)));
  EXPECT_EQ(events_of("contradiction"), 0);
}

TEST_F(State, ADoneElsewhereIsRefusedAndRecorded) {
  watch().learn_zero(rest_between(0.010, 0.012));
  show(0.011, 0.4e-3);
  const auto r = confirm(to_travel(1e-3), done_at(1e-3, 0.011));
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::refused);
  EXPECT_THAT(r.error().what, HasSubstr("it was to go to 1.0000 mm, and shows 0.4000 mm"));
  EXPECT_EQ(events_of("contradiction"), 1);
}

// The last sample is older than the frame's message; the next one may confirm it.
TEST_F(State, TheSamplesMayComeLater) {
  watch().learn_zero(rest_between(0.010, 0.012));
  show(0.011, 0.9e-3);
  auto late = [](Clock& time, std::function<void()> act) -> Task<> {
    co_await time.wait_for(50ms);
    act();
  };
  bool ended = false;
  start(late(clock, [this] { show(0.011, 1e-3); }), ended);
  EXPECT_TRUE(confirm(to_travel(1e-3), done_at(1e-3, 0.011)));
  EXPECT_TRUE(ended);
}

TEST_F(State, AMotionThatDidNotReachItsTargetIsNotJudged) {
  watch().learn_zero(rest_between(0.010, 0.012));
  show(0.011, 0.4e-3);
  MotionOutcome stopped = done_at(0.4e-3, 0.011);
  stopped.reason = MotionEnd::stopped;
  EXPECT_TRUE(confirm(to_travel(1e-3), stopped));
}

// The relaxation that a specimen is allowed grows with the force that is felt.
TEST_F(State, ALoadedMotionIsAllowedMoreThanAnUnloadedOne) {
  watch().learn_zero(rest_between(0.010, 0.012));
  show(0.011, 0);
  const double bare_N = motion_now(1, 1e-5).against_N;
  show(0.611, 0);
  const double loaded_N = motion_now(1, 1e-5).against_N;
  EXPECT_GT(loaded_N, bare_N + 0.05);
  EXPECT_LT(motion_now(-1, 1e-5).against_N, loaded_N);
}

// The force before an overload says nothing about the way back from the overload.
TEST_F(State, OnTheWayBackFromAnOverloadTheForceMayBeAsHighAsItIs) {
  watch().learn_zero(rest_between(0.010, 0.012));
  show(0.5, 1e-3);
  FrameSample dark = frame.sample();
  dark.force_N.reset();
  dark.flags = frame_flag::kForceOverload;
  watch().add(dark);
  EXPECT_TRUE(motion_now(1, 1e-5).force_known) << "towards the specimen nothing is excused";
  watch().order(motion_now(-1, 1e-5));
  const auto check = [this](double force_N, double travel_m) {
    return std::ranges::any_of(show(force_N, travel_m),
                               [](const Finding& f) { return f.check->doubt == Doubt::drive; });
  };
  EXPECT_FALSE(check(4.6, 0.9e-3));
  EXPECT_FALSE(check(3.0, 0.8e-3));
  EXPECT_TRUE(check(5.2, 0.7e-3)) << "now it rises";
}

TEST_F(State, AFrameThatThisRunDoesNotMoveIsBelieved) {
  setup().commands = false;
  EXPECT_FALSE(rig().needs_live_cell());
  show(0.011, 0.4e-3);
  EXPECT_TRUE(confirm(to_travel(1e-3), done_at(1e-3, 0.011)));
}

// A state that contradicts itself is a fault of this program: the run stops, and `finally` runs.
TEST_F(State, AContradictionInItselfStopsTheRunOnce) {
  watch().know_least_stiffness(5e-3, 0.02, 0);  // known, and none
  watch().know_least_stiffness(5e-3, 0.02, 0);
  const InterruptRequest stop = parts().interrupts.take();
  EXPECT_EQ(stop.kind, Interrupt::fault);
  EXPECT_EQ(stop.code, Errc::bug);
  EXPECT_THAT(stop.why, HasSubstr("a contact without a stiffness"));
  EXPECT_TRUE(parts().interrupts.empty());
}

TEST_F(State, KnowsWhatCannotBe) {
  RigFacts facts = rig().facts;
  const RigState sound(facts, setup().forecast);
  EXPECT_FALSE(sound.broken_invariant());
  RigState broken = sound;
  broken.trust.force = false;
  EXPECT_TRUE(broken.broken_invariant()) << "an invalid force still limits";
  broken = sound;
  broken.limits.travel_min_m = 2e-3;
  broken.limits.travel_max_m = 1e-3;
  EXPECT_TRUE(broken.broken_invariant());
  broken = sound;
  broken.cell.below_zero_N = -0.1;
  EXPECT_TRUE(broken.broken_invariant()) << "a zero that raises the limit";
  broken = sound;
  broken.cell.hidden_N = -0.1;
  EXPECT_TRUE(broken.broken_invariant());
  broken = RigState(facts, std::nullopt);
  broken.frame.motion = FrameMotion::moving;
  EXPECT_TRUE(broken.broken_invariant()) << "this run does not move it";
}

// All zeros of a run are one sum, and one under load hides its force from the lower limit.
TEST_F(State, AZeroIsOneFact) {
  watch().learn_zero(rest_between(0.010, 0.012));
  const double least_N = rig().limits.force_min_N;
  watch().zeroed(rest_between(0.310, 0.312), true, false, 0.3);
  watch().zero_measured(rest_between(0.310, 0.312), rest_between(-0.001, 0.001), 0.3);
  EXPECT_NEAR(rig().cell.zeros_N.value(), 0.311, 1e-9);
  EXPECT_NEAR(rig().limits.force_min_N, least_N - 0.3, 1e-9);
  EXPECT_NEAR(rig().cell.unloaded_N(), 0.011 - 0.311, 1e-9);
  EXPECT_TRUE(rig().frame.seen.zeroed);
  watch().zeroed(rest_between(0.010, 0.012), true, false, 0);
  watch().zero_measured(rest_between(0.010, 0.012), rest_between(-0.001, 0.001), 0);
  EXPECT_NEAR(rig().cell.zeros_N.value(), 0.322, 1e-9);
  EXPECT_NEAR(rig().limits.force_min_N, least_N, 1e-9) << "it hides nothing";
  EXPECT_NEAR(rig().cell.unloaded_N(), 0, 1e-9);
}

}  // namespace
}  // namespace lcrig
