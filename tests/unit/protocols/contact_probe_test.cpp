// SPDX-License-Identifier: Apache-2.0
// The look at what was touched, without the search before it.
#include "protocols/contact/contact_probe.hpp"

#include <gmock/gmock.h>

#include <random>

#include "protocols/rig/permit.hpp"
#include "tests/support/relaxing_contact.hpp"
#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class Probe : public RunFixture {
 protected:
  static constexpr double kContact_m = 5e-3, kStiffness_N_m = 1e4, kThreshold_N = 0.02;
  static constexpr double kDeep_N = 0.5;  // a threshold far inside the specimen
  static constexpr double kSpeed_m_s = 1e-4;  // of the search
  static constexpr double kTouched_m = kContact_m + kThreshold_N / kStiffness_N_m;

  Probe() {
    frame.noise_N = 1e-4;
    frame.travel_m = 4.9e-3;
    feed();
    restart_at_rest();
  }
  void restart_at_rest() {
    restart().log.begin_step(step(0));
    before_ = run(parts().meter.measure_alive()).value();
    parts().watch.learn_zero(before_);
    sink.events.clear();
  }
  void restart_with_travel_step(std::optional<double> step_m) {
    frame.abilities().travel_step.reset();
    if (step_m) frame.abilities().travel_step = Length::from_si(*step_m);
    restart_at_rest();
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
  // The highest force of a spring on the way back from where the travel shows this.
  double highest_N_on_way_back(double shown_m) {
    touch([this](double travel_m) {
      highest_N_ = std::max(highest_N_, spring(travel_m));
      return spring(travel_m);
    });
    const auto stepped = run(probe.step_back(shown_m));
    EXPECT_TRUE(stepped) << stepped.error().what;
    return highest_N_;
  }
  RestMeasurement look_at(double travel_m) {
    frame.travel_m = travel_m;
    return run(parts().meter.measure(kLook_s.duration())).value();
  }
  // Shows the samples of the approach, at these distances before contact.
  void show_step(std::initializer_list<double> off_m) {
    for (const double x : off_m) show(0, kContact_m - x);
  }
  const StiffnessEvent& stiffness() const { return *sink.events.back().as<StiffnessEvent>(); }
  static double spring(double travel_m) {
    return kStiffness_N_m * std::max(0.0, travel_m - kContact_m);
  }

  RestMeasurement before_;
  double highest_N_ = 0;
  ContactProbe probe{parts(), before_, kThreshold_N};
};

TEST_F(Probe, OfASpringIsAContactAndNeverPressesHarder) {
  EXPECT_LE(highest_N_on_way_back(kTouched_m), spring(kTouched_m));
  EXPECT_TRUE(probe.is_contact());
  EXPECT_NEAR(probe.touched_N(), kThreshold_N, 2e-4);
  EXPECT_LT(frame.travel_m, kTouched_m);
}

TEST_F(Probe, StepsBackNoFurtherThanItHasTo) {
  touch(spring);
  step_back();
  EXPECT_GT(frame.travel_m, kContact_m - 2e-6) << "a third of the force is left at most";
}

// Steps of 0.2, 0.4, 0.8, 1.6 um leave 90, 50, 40 and 20 % of the force.
TEST_F(Probe, StepsBackUntilThreeTenthsOfTheForceAreLeft) {
  touch([](double travel_m) {
    const double back_m = kTouched_m - travel_m;
    const double part = back_m < 0.1e-6   ? 1
                        : back_m < 0.3e-6 ? 0.9
                        : back_m < 0.6e-6 ? 0.5
                        : back_m < 1e-6   ? 0.4
                        : back_m < 2e-6   ? 0.2
                                          : 0;
    return part * kThreshold_N;
  });
  step_back();
  EXPECT_NEAR(frame.travel_m, kTouched_m - 1.6e-6, 1e-8);
}

TEST_F(Probe, StepsBackHalfAMillimetreAtMost) {
  touch([](double) { return kThreshold_N; });
  step_back();
  EXPECT_NEAR(frame.travel_m, kTouched_m - 2e-7 * 2048, 1e-7) << "0.41 mm; the next is twice that";
}

// 7 % of the force are left after the first step: too little to be sure that it still touches.
TEST_F(Probe, TellsNoStiffnessOfAContactThatMayBeLost) {
  touch([](double travel_m) {
    const double back_m = kTouched_m - travel_m;
    return kThreshold_N * (back_m < 0.1e-6 ? 1 : back_m < 0.3e-6 ? 0.07 : 0);
  });
  step_back();
  probe.conclude_stiffness(look_at(4e-3), kSpeed_m_s);
  EXPECT_FALSE(stiffness().stiffness_N_m);
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
  show_step({100e-6, 99.9e-6, 99.8e-6});
  touch([](double travel_m) { return travel_m < kTouched_m - 1e-7 ? 0.1 : kThreshold_N; });
  step_back();
  EXPECT_EQ(std::ranges::count(frame.commands, "move_to"), 1);
  EXPECT_FALSE(probe.is_contact());
}

TEST_F(Probe, OfAForceThatRisesOnTheWayBackAndNotAtRestIsThatOfADriveThatPresses) {
  touch([](double travel_m) { return kThreshold_N + kStiffness_N_m * (kTouched_m - travel_m); });
  step_back();
  EXPECT_TRUE(probe.rose());
  EXPECT_GT(probe.rose_beyond_N(run(parts().meter.measure(3s)).value()), 4e-3);
}

TEST_F(Probe, OfAForceThatRisesAtRestAsOnTheWayBackIsADrift) {
  const MonoTime begun = clock.now();
  touch([&](double) { return kThreshold_N + 5e-3 * to_seconds(clock.now() - begun); });
  step_back();
  EXPECT_TRUE(probe.rose());
  EXPECT_LE(probe.rose_beyond_N(run(parts().meter.measure(3s)).value()), 0);
}

// The cell shows a tenth of the force when the probe stops.
TEST_F(Probe, OfACellWithAFilterWaitsUntilItHasFollowed) {
  static constexpr double kFilter_s = 0.6, kForce_N = 0.2;
  frame.abilities().reaction = 600ms;
  const MonoTime begun = clock.now();
  touch([&](double travel_m) {
    const double late = 0.9 * std::exp(-to_seconds(clock.now() - begun) / kFilter_s);
    return (1 - late) * (kForce_N - kStiffness_N_m * (kTouched_m - travel_m));
  });
  step_back();
  EXPECT_FALSE(probe.rose());
  EXPECT_TRUE(probe.is_contact());
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
  restart_with_travel_step(7e-6);
  frame.digit_m = 7e-6;
  show_step({100e-6, 90e-6, 70e-6, 60e-6, 50e-6, 40e-6, 30e-6, 20e-6});
  EXPECT_LE(highest_N_on_way_back(5.005e-3), spring(kTouched_m));
  EXPECT_TRUE(probe.is_contact());
}

// Nothing is stated, and the few steps show nothing: the travel may be as coarse as any.
TEST_F(Probe, OfATravelOfUnknownStepGoesBackByTheCoarsest) {
  restart_with_travel_step(std::nullopt);
  frame.digit_m = 7e-6;
  show_step({100e-6, 60e-6, 20e-6});
  EXPECT_LE(highest_N_on_way_back(5.005e-3), spring(kTouched_m));
  EXPECT_EQ(std::ranges::count(frame.commands, "move_to"), 1);
}

// What is stated counts, whatever its few steps looked like.
TEST_F(Probe, OfAFineTravelStepsBackByLittle) {
  frame.digit_m = 1e-7;
  show_step({100e-6, 92e-6, 84e-6});
  touch(spring);
  step_back();
  EXPECT_EQ(std::ranges::count(frame.commands, "move_to"), 4) << "0.2, 0.4, 0.8 and 1.6 um";
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
  EXPECT_FALSE(parts().rig.trust.force);
}

TEST_F(Probe, OfAForceThatFallsWithinItsScatterBlamesTheFrameOnly) {
  frame.noise_N = 0.05;
  touch(spring);
  step_back();
  const auto felt = probe.check_felt(-kThreshold_N);
  ASSERT_FALSE(felt);
  EXPECT_THAT(felt.error().what, HasSubstr("does the frame hunt?"));
  EXPECT_TRUE(parts().rig.trust.force);
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
  const auto refused = permit_to_force(parts().rig, 0.5, 5e-3);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what,
              HasSubstr("nothing was measured at contact: the first step back, 0.2 um, left it"));
}

// The cell showed 0.3 N before, and the contact is counted from there.
TEST_F(Probe, OfACellThatIsNotTaredTellsTheSame) {
  const auto shifted = [](double travel_m) { return 0.3 + spring(travel_m); };
  frame.force_at = shifted;
  restart_at_rest();
  ContactProbe tared(parts(), before_, kThreshold_N);
  touch(shifted);
  const auto stepped = run(tared.step_back(kTouched_m));
  ASSERT_TRUE(stepped) << stepped.error().what;
  EXPECT_TRUE(tared.is_contact());
  EXPECT_LT(tared.depth_m(), 10e-6) << "twice the way from 0.02 N would be 6 um";
  const RestMeasurement after = look_at(4e-3);
  EXPECT_FALSE(tared.presses(after));
  tared.conclude_stiffness(after, kSpeed_m_s);
  ASSERT_TRUE(stiffness().stiffness_N_m);
  EXPECT_NEAR(*stiffness().stiffness_N_m, kStiffness_N_m, 0.1 * kStiffness_N_m);
}

// The zero of a cell may err by a tenth of its class. That much more than before is no pressure.
TEST_F(Probe, WhatTheZeroOfTheCellMayShowDoesNotPress) {
  touch(spring);
  step_back();
  const double zero_N = parts().rig.zero_uncertainty_N();
  ASSERT_GT(zero_N, 20 * frame.noise_N);
  for (const double part : {0.5, 2.0}) {
    frame.force_at = [=](double) { return part * zero_N; };
    EXPECT_EQ(probe.presses(look_at(kTouched_m - 1e-6)), part > 1) << part;
  }
}

TEST_F(Probe, ProvesNothingOfAForceThatStays) {
  touch([](double) { return kThreshold_N; });
  step_back();
  probe.conclude_stiffness(look_at(4e-3), kSpeed_m_s);
  EXPECT_FALSE(parts().rig.contact.least);
}

// A search that overran felt a newton. What it loses on the way back is little of that, and still
// more than contact at the threshold is.
TEST_F(Probe, OfAnOverrunIsAContactByWhatTheThresholdTells) {
  touch([](double travel_m) { return travel_m < kTouched_m - 1e-7 ? 0.97 : 1.0; });
  step_back();
  EXPECT_TRUE(probe.is_contact());
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

class ProbeOfRelaxing : public Probe {
 protected:
  ProbeOfRelaxing() { frame.sample_period = std::chrono::milliseconds(20); }
  // What is told of this rig: nullopt, if nothing was measured.
  std::optional<StiffnessEvent> tells(const RelaxingRig& rig) {
    const FrameCapabilities& caps = frame.capabilities();
    const ForceBound expected({}, rig.stiffness_N_m);
    setup().forecast.emplace(caps, ForceBound({}, 2 * rig.quick_N_m()), expected);
    restart_at_rest();
    frame.force_at = nullptr;
    show_step({100e-6, 99.9e-6, 99.8e-6});
    RelaxingContact contact(rig, kContact_m, clock.now());
    frame.travel_m = contact.touched_m();
    frame.force_at = [&](double travel_m) { return contact.force_at(travel_m, clock.now()); };
    ContactProbe relaxing(parts(), before_, rig.felt_N);
    const auto stepped = run(relaxing.step_back(frame.travel_m));
    EXPECT_TRUE(stepped) << stepped.error().what;
    EXPECT_TRUE(relaxing.is_contact());
    relaxing.conclude_stiffness(look_at(4e-3), 1e-6);
    frame.force_at = nullptr;
    frame.force_N = 0;
    if (!stiffness().stiffness_N_m) return std::nullopt;
    return stiffness();
  }
  // By which a motion is judged that stops at `from_N` and goes on for `way_m`.
  double forecast_N(double from_N, double way_m) {
    return parts().rig.forecast->bound().force_after_N(from_N, way_m);
  }
};

// The fall in time was taken for a fall on the way back, and the contact for three times softer.
TEST_F(ProbeOfRelaxing, TakesTheFallInTheLostMotionForNoStiffness) {
  const RelaxingRig rig;
  const auto told = tells(rig);
  EXPECT_GE(told ? *told->at_most_N_m : 1e9, rig.stiffness_N_m);
  EXPECT_GE(forecast_N(0.3, 2e-6), 0.3 + rig.quick_N_m() * 2e-6);
}

TEST_F(ProbeOfRelaxing, WithoutPlayIsMeasured) {
  for (const double relaxes_s : {0.3, 1.0, 2.0}) {
    RelaxingRig rig;
    rig.play_m = 0;
    rig.relaxes_s = relaxes_s;
    for (const double stiffness_N_m : {5e3, 50e3, 300e3}) {
      rig.stiffness_N_m = stiffness_N_m;
      const auto told = tells(rig);
      ASSERT_TRUE(told) << relaxes_s << " s, " << stiffness_N_m << " N/m";
      EXPECT_GE(*told->at_most_N_m, rig.stiffness_N_m);
      EXPECT_LT(*told->at_most_N_m, 3 * rig.quick_N_m());
    }
  }
}

TEST_F(ProbeOfRelaxing, OfAnyRigIsNeverTakenForMuchSofter) {
  std::mt19937 random(11);
  const auto even = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  int measured = 0;
  constexpr int kRigs = 600;
  for (int i = 0; i < kRigs; ++i) {
    RelaxingRig rig;
    rig.stiffness_N_m = std::exp(even(std::log(5e3), std::log(600e3)));
    rig.falls = even(0, 0.4);
    rig.relaxes_s = std::exp(even(std::log(0.3), std::log(2)));
    rig.play_m = even(0, 20e-6);
    rig.felt_N = even(0.1, 0.95);
    rig.approach_s = std::exp(even(std::log(0.02), std::log(20)));
    const auto told = tells(rig);
    if (!told) continue;
    ++measured;
    EXPECT_GE(*told->at_most_N_m, 0.95 * rig.stiffness_N_m)
        << rig.stiffness_N_m << " N/m, falls by " << rig.falls << " in " << rig.relaxes_s
        << " s, play " << rig.play_m << ", felt " << rig.felt_N << ", approach " << rig.approach_s;
  }
  EXPECT_GT(measured, 0.25 * kRigs);
}

// A search that overran its threshold: the force rose while the frame stopped.
class ProbeAfterOverrun : public Probe {
 protected:
  bool tells_stiffness(double speed_m_s) {
    const FrameCapabilities& caps = frame.capabilities();
    const ForceBound expected({}, kStiffness_N_m);
    setup().forecast.emplace(caps, ForceBound({}, 120e3), expected);
    restart_at_rest();
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
  const RestMeasurement after = look_at(4e-3);
  EXPECT_EQ(&probe.off_contact(after), &after);
}

// A search that overran its contact: the way back ended nearer than the last step of the look.
TEST_F(Probe, TakesItsLastStepWhereTheWayBackStillPresses) {
  touch(spring);
  step_back();
  const RestMeasurement pressing = look_at(kTouched_m);
  const RestMeasurement& bare = probe.off_contact(pressing);
  EXPECT_NE(&bare, &pressing);
  EXPECT_LT(bare.force_N(), pressing.force_N());
}

// The place where the specimen is touched first, as the way back shows it.
TEST_F(Probe, TellsHowFarBackTheSpecimenMayStillBeTouched) {
  touch(spring);
  step_back();
  EXPECT_GE(probe.depth_m(), kTouched_m - kContact_m);
  EXPECT_LT(probe.depth_m(), 3 * (kTouched_m - kContact_m));
}

TEST_F(Probe, StillPressesWhereTheWayBackIsShorterThanThat) {
  touch(spring);
  ContactProbe deep(parts(), before_, kDeep_N);
  frame.travel_m = kContact_m + kDeep_N / kStiffness_N_m;
  ASSERT_TRUE(run(deep.step_back(frame.travel_m)));
  EXPECT_TRUE(deep.presses(look_at(kContact_m + 0.2 * kDeep_N / kStiffness_N_m)));
  EXPECT_FALSE(deep.presses(look_at(kContact_m - 1e-6)));
}

}  // namespace
}  // namespace lcrig
