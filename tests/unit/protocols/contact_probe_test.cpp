// SPDX-License-Identifier: Apache-2.0
// The look at what was touched, without the search before it.
#include "protocols/run/contact_probe.hpp"

#include <gmock/gmock.h>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

class Probe : public RunFixture {
 protected:
  static constexpr double kContact_m = 5e-3, kStiffness_N_m = 1e4, kThreshold_N = 0.02;
  static constexpr double kSpeed_m_s = 1e-4;  // of the search
  static constexpr double kTouched_m = kContact_m + kThreshold_N / kStiffness_N_m;

  Probe() {
    frame.noise_N = 1e-4;
    frame.travel_m = 4.9e-3;
    feed();
    parts().log.begin_step(step(0));
    before_ = run(parts().view.living_rest()).value();
    parts().truth.learn_rest(before_);
    sink.events.clear();
  }
  // Puts the frame where the threshold was reached.
  void touch(std::function<double(double)> force_at) {
    frame.force_at = std::move(force_at);
    frame.travel_m = kTouched_m;
  }
  void step_back() {
    const auto stepped = run(probe.step_back(kTouched_m));
    ASSERT_TRUE(stepped) << stepped.error().what;
  }
  Rest look_at(double travel_m) {
    frame.travel_m = travel_m;
    return run(parts().view.watch_rest(ContactProbe::kLook)).value();
  }
  // Shows the samples of the approach, at these distances before contact.
  void show_digit(std::initializer_list<double> off_m) {
    parts().pressing->begin(Pressing::Permit());
    for (const double x : off_m) {
      frame.travel_m = kContact_m - x;
      const FrameSample s = frame.sample();
      parts().pressing->add(std::span(&s, 1));
    }
    parts().pressing->end(MotionOutcome(), 0);
  }
  const StiffnessEvent& stiffness() const { return *sink.events.back().as<StiffnessEvent>(); }
  static double spring(double travel_m) {
    return kStiffness_N_m * std::max(0.0, travel_m - kContact_m);
  }

  Rest before_;
  ContactProbe probe{parts(), before_, kThreshold_N};
};

TEST_F(Probe, OfASpringIsAContactAndNeverPressesHarder) {
  double highest_N = 0;
  touch([&](double travel_m) {
    highest_N = std::max(highest_N, spring(travel_m));
    return spring(travel_m);
  });
  step_back();
  EXPECT_TRUE(probe.is_contact());
  EXPECT_NEAR(probe.touched_N(), kThreshold_N, 2e-4);
  EXPECT_LT(frame.travel_m, kTouched_m);
  EXPECT_LE(highest_N, spring(kTouched_m));
}

TEST_F(Probe, StepsBackNoFurtherThanItHasTo) {
  touch(spring);
  step_back();
  EXPECT_GT(frame.travel_m, kContact_m - 2e-6) << "a third of the force is left at most";
}

TEST_F(Probe, OfAForceThatStaysIsNoContact) {
  touch([](double) { return kThreshold_N; });
  step_back();
  EXPECT_FALSE(probe.is_contact());
}

TEST_F(Probe, OfAForceThatWasGoneOnceTheFrameStoodIsNoContact) {
  touch([](double) { return 0; });
  step_back();
  EXPECT_FALSE(probe.is_contact());
}

TEST_F(Probe, StopsWhereTheForceRisesOnTheWayBack) {
  touch([](double travel_m) { return travel_m < kTouched_m - 1e-7 ? 0.1 : kThreshold_N; });
  step_back();
  EXPECT_EQ(std::ranges::count(frame.commands, "move_to"), 1);
  EXPECT_FALSE(probe.is_contact());
}

TEST_F(Probe, StaysWithinTheLimitsOfTravel) {
  frame.force_N = kThreshold_N;
  frame.travel_m = 1e-6;
  EXPECT_TRUE(run(probe.step_back(1e-6)));
  EXPECT_GE(frame.travel_m, 0);
  EXPECT_EQ(std::ranges::count(frame.commands, "move_to"), 3) << "0.2, 0.4 and 0.8 um back";
}

// It stands at 5.002 mm and shows 5.005 mm. A place less than a digit before that is deeper.
TEST_F(Probe, OfACoarseTravelIsNoStepDeeper) {
  frame.digit_m = 7e-6;
  show_digit({100e-6, 90e-6, 70e-6, 60e-6, 50e-6, 40e-6, 30e-6, 20e-6});
  double highest_N = 0;
  touch([&](double travel_m) {
    highest_N = std::max(highest_N, spring(travel_m));
    return spring(travel_m);
  });
  const auto stepped = run(probe.step_back(5.005e-3));
  ASSERT_TRUE(stepped) << stepped.error().what;
  EXPECT_LE(highest_N, spring(kTouched_m));
  EXPECT_TRUE(probe.is_contact());
}

TEST_F(Probe, PassesOnThatTheFrameIsSilent) {
  touch(spring);
  frame.set_listener(nullptr);
  const auto stepped = run(probe.step_back(kTouched_m));
  ASSERT_FALSE(stepped);
  EXPECT_EQ(stepped.error().code, Errc::no_reply);
}

TEST_F(Probe, BelievesAForceThatRises) {
  touch(spring);
  step_back();
  EXPECT_TRUE(probe.check_felt(kThreshold_N));
  EXPECT_EQ(events_of("contradiction"), 0);
}

TEST_F(Probe, OfAForceThatFallsSaysThatTheCellIsTheWrongWayRound) {
  touch([](double travel_m) { return -spring(travel_m); });
  step_back();
  const auto felt = probe.check_felt(-kThreshold_N);
  ASSERT_FALSE(felt);
  EXPECT_THAT(felt.error().what, HasSubstr("the load cell is connected the wrong way"));
  EXPECT_EQ(events_of("contradiction"), 1);
  EXPECT_TRUE(parts().guard.is_distrusted());
}

TEST_F(Probe, OfAForceThatFallsWithinItsScatterBlamesTheFrameOnly) {
  frame.noise_N = 0.05;
  touch(spring);
  step_back();
  const auto felt = probe.check_felt(-kThreshold_N);
  ASSERT_FALSE(felt);
  EXPECT_THAT(felt.error().what, HasSubstr("does the frame hunt?"));
  EXPECT_FALSE(parts().guard.is_distrusted());
}

TEST_F(Probe, TellsTheStiffnessBetweenItsBounds) {
  touch(spring);
  step_back();
  probe.conclude_stiffness(look_at(4e-3), kSpeed_m_s);
  ASSERT_TRUE(stiffness().stiffness_N_m);
  EXPECT_NEAR(*stiffness().stiffness_N_m, kStiffness_N_m, 0.1 * kStiffness_N_m);
  EXPECT_LE(*stiffness().at_least_N_m, kStiffness_N_m);
  EXPECT_GE(*stiffness().at_most_N_m, kStiffness_N_m);
}

TEST_F(Probe, TellsNoStiffnessOfAContactThatIsLostAtOnce) {
  // 0.2 um further back nothing touches any more, so the specimen may be arbitrarily stiff.
  touch([](double travel_m) { return travel_m < kTouched_m - 1e-7 ? 0 : kThreshold_N; });
  step_back();
  EXPECT_TRUE(probe.is_contact());
  probe.conclude_stiffness(look_at(4e-3), kSpeed_m_s);
  EXPECT_FALSE(stiffness().stiffness_N_m);
}

// The drive has lost motion, so the probe goes back only after the play was taken up.
class ProbeWithPlay : public Probe, public testing::WithParamInterface<double> {};

TEST_P(ProbeWithPlay, TakesTheContactForNoSofterThanItIs) {
  const double play_m = GetParam() * 1e-6;
  touch([play_m, at_m = kTouched_m](double travel_m) mutable {
    at_m = std::clamp(at_m, travel_m, travel_m + play_m);
    return spring(at_m);
  });
  step_back();
  probe.conclude_stiffness(look_at(4e-3), kSpeed_m_s);
  EXPECT_GE(stiffness().at_most_N_m.value_or(1e9), kStiffness_N_m);
}

INSTANTIATE_TEST_SUITE_P(um, ProbeWithPlay, testing::Values(0.3, 0.5, 0.7, 1, 1.3, 2, 3, 5, 10));

// A search that overran its threshold: the force rose while the frame stopped.
class ProbeAfterOverrun : public Probe {
 protected:
  bool tells_stiffness(double speed_m_s) {
    const FrameCapabilities& caps = frame.capabilities();
    const ForceBound expected({}, kStiffness_N_m);
    setup().pressing.emplace(Forecast(caps, ForceBound({}, 120e3), expected), caps);
    ContactProbe overran(parts(), before_, kThreshold_N / 4);
    touch(spring);
    EXPECT_TRUE(run(overran.step_back(kTouched_m)));
    overran.conclude_stiffness(look_at(4e-3), speed_m_s);
    return stiffness().stiffness_N_m.has_value();
  }
};

TEST_F(ProbeAfterOverrun, TellsAStiffnessThatExplainsIt) {
  EXPECT_TRUE(tells_stiffness(2e-4));
}

TEST_F(ProbeAfterOverrun, TellsNoStiffnessThatDoesNot) {
  EXPECT_FALSE(tells_stiffness(5e-5)) << "0.015 N on 0.4 um, at 10 N/mm";
}

TEST_F(Probe, TakesTheLookAfterTheWayBackAsTheOneWithoutContact) {
  touch(spring);
  step_back();
  const Rest after = look_at(4e-3);
  EXPECT_EQ(&probe.off_contact(after), &after);
}

// A search that overran its contact: the way back ended nearer than the last step of the look.
TEST_F(Probe, TakesItsLastStepWhereTheWayBackStillPresses) {
  touch(spring);
  step_back();
  const Rest pressing = look_at(kTouched_m);
  const Rest& bare = probe.off_contact(pressing);
  EXPECT_NE(&bare, &pressing);
  EXPECT_LT(bare.force_N(), pressing.force_N());
}

}  // namespace
}  // namespace lcrig
