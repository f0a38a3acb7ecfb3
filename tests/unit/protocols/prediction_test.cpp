// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/prediction.hpp"

#include <gtest/gtest.h>

#include "protocols/rig/permit.hpp"
#include "tests/support/watched_frame.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

constexpr double kNoise_N = 0.002;

ForcePrediction of_class(ForceClass cell) {
  return ForcePrediction(cell, 224ms);
}

// To stop at 0.5 N, at 0.6 N at most.
Permit to_half_a_newton(bool presses = true) {
  Permit permit;
  permit.threshold_N = 0.5;
  permit.limits.force_max = 1.5_N;
  permit.worst_N = 0.6;
  permit.presses = presses;
  return permit;
}

MotionOutcome target(double force_N) {
  MotionOutcome o;
  o.force_N = force_N;
  return o;
}

FrameSample shown(double force_N, Duration at = 0ms) {
  FrameSample s;
  s.force_N = force_N;
  s.received = MonoTime() + at;
  return s;
}

TEST(ForcePrediction, AMotionWithinItIsAnOvershoot) {
  ForcePrediction prediction = of_class(kAssumedForceClass);
  prediction.begin(to_half_a_newton());
  const auto good = prediction.end(target(0.6), kNoise_N);
  ASSERT_TRUE(good);
  EXPECT_FALSE(good->exceeded);
  EXPECT_EQ(good->observed_N, 0.6);
}

TEST(ForcePrediction, TheLargestSampleOfAMotionCounts) {
  ForcePrediction prediction = of_class(kAssumedForceClass);
  prediction.begin(to_half_a_newton());
  EXPECT_FALSE(prediction.add(shown(0.7)));
  const auto bad = prediction.end(target(0.5), kNoise_N);
  ASSERT_TRUE(bad);
  EXPECT_TRUE(bad->exceeded);
  EXPECT_EQ(bad->observed_N, 0.7);
}

// A cell may show as much more than the prediction as its class allows, and no more.
TEST(ForcePrediction, ACellIsJudgedByItsOwnClass) {
  for (const double percent : kForceClasses) {
    const auto exceeds = [percent](double part, double noise_N) {
      ForcePrediction prediction = of_class(ForceClass(percent));
      prediction.begin(to_half_a_newton());
      return prediction.end(target(0.6 * (1 + part)), noise_N)->exceeded;
    };
    EXPECT_FALSE(exceeds(0.99 * percent / 100, 0)) << percent;
    EXPECT_TRUE(exceeds(1.01 * percent / 100, 0)) << percent;
    EXPECT_FALSE(exceeds(1.01 * percent / 100, kNoise_N)) << "noise";
  }
}

// The limit of the frame ended the motion. That it was needed shows that the prediction was wrong.
TEST(ForcePrediction, AForceLimitThatCutAMotionShortCountsAsExceeded) {
  ForcePrediction prediction = of_class(kAssumedForceClass);
  prediction.begin(to_half_a_newton());
  MotionOutcome cut = target(1.6);
  cut.reason = MotionEnd::force_limit;
  ASSERT_TRUE(prediction.end(cut, kNoise_N));
  prediction.begin(to_half_a_newton());
  cut.force_N = 0.55;
  EXPECT_FALSE(prediction.end(cut, kNoise_N)) << "within its bound: nothing to report";
}

TEST(ForcePrediction, AMotionThatDoesNotPressIsNotCompared) {
  ForcePrediction prediction = of_class(kAssumedForceClass);
  prediction.begin(to_half_a_newton(false));
  EXPECT_FALSE(prediction.end(target(2), kNoise_N));
  EXPECT_FALSE(prediction.end(target(2), kNoise_N)) << "nor one that never started";
}

TEST(ForcePrediction, AWayIntoTheSpecimenIsComparedWithTheForceLimit) {
  ForcePrediction prediction = of_class(kAssumedForceClass);
  Permit permit = to_half_a_newton();
  permit.threshold_N.reset();
  prediction.begin(permit);
  EXPECT_FALSE(prediction.end(target(0.55), kNoise_N)) << "as predicted: nothing to report";
  prediction.begin(permit);
  const auto bad = prediction.end(target(0.74), kNoise_N);
  ASSERT_TRUE(bad);
  EXPECT_EQ(bad->threshold_N, 1.5);
}

// The cell has a filter, and DONE comes before it has followed.
class ShownLate : public testing::Test {
 protected:
  ShownLate() {
    prediction_.begin(to_half_a_newton());
    EXPECT_FALSE(prediction_.end(target(0.51), kNoise_N).value().exceeded);
  }
  std::optional<ForceComparison> show(double force_N, Duration at) {
    return prediction_.add(shown(force_N, at));
  }
  ForcePrediction prediction_ = of_class(kAssumedForceClass);
};

TEST_F(ShownLate, AForceBeyondThePredictionIsReportedOnce) {
  EXPECT_FALSE(show(0.55, 10ms));
  const auto late = show(0.7, 60ms);
  ASSERT_TRUE(late);
  EXPECT_TRUE(late->exceeded);
  EXPECT_EQ(late->observed_N, 0.7);
  EXPECT_FALSE(show(0.8, 80ms));
}

TEST_F(ShownLate, AForceWithinThePredictionIsReportedWhenTheFilterIsOver) {
  prediction_.begin(to_half_a_newton(false));
  EXPECT_FALSE(show(0.51, 10ms));
  EXPECT_FALSE(show(0.6, 60ms));
  const auto late = show(0.1, 500ms);
  ASSERT_TRUE(late);
  EXPECT_FALSE(late->exceeded);
  EXPECT_EQ(late->observed_N, 0.6);
}

// A cell that is not tared shows less than nothing, and a sample without a force shows none.
TEST(ForcePrediction, AMotionWithoutAnyForceIsNotCompared) {
  ForcePrediction prediction = of_class(kAssumedForceClass);
  prediction.begin(to_half_a_newton());
  MotionOutcome blind;
  blind.reason = MotionEnd::target;
  EXPECT_FALSE(prediction.end(blind, kNoise_N));
}

TEST(ForcePrediction, OfACellBelowZeroIsNotBrokenByZero) {
  ForcePrediction prediction = of_class(kAssumedForceClass);
  Permit permit = to_half_a_newton();
  permit.threshold_N = -0.06;
  permit.worst_N = -0.01;
  prediction.begin(permit);
  const auto first = prediction.end(target(-0.06), kNoise_N);
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->exceeded);
  FrameSample mute = shown(0, 20ms);
  mute.force_N.reset();
  EXPECT_FALSE(prediction.add(mute));
  EXPECT_FALSE(prediction.add(shown(-0.061, 40ms)));
  const auto late = prediction.add(shown(0.05, 60ms));
  ASSERT_TRUE(late);
  EXPECT_TRUE(late->exceeded);
}

TEST_F(ShownLate, NothingIsReportedOfNoiseNorOfLaterForces) {
  EXPECT_FALSE(show(0.515, 10ms));
  EXPECT_FALSE(show(0.7, 500ms));
  EXPECT_FALSE(show(0.1, 600ms));
}

TEST_F(ShownLate, WhatIsStillToBeShownExceedsNoPredictionOfTheNextMotion) {
  Permit slow = to_half_a_newton();
  slow.worst_N = 0.52;
  prediction_.begin(slow);
  EXPECT_FALSE(show(0.6, 60ms));
  EXPECT_FALSE(prediction_.end(target(0.52), kNoise_N).value().exceeded);
}

TEST_F(ShownLate, TheNextMotionThatPressesEndsIt) {
  prediction_.begin(to_half_a_newton());
  EXPECT_FALSE(show(0.7, 60ms)) << "it is judged at its own end";
}

TEST_F(ShownLate, AForceLoopMayRaiseTheForce) {
  prediction_.leave_to_loop();
  EXPECT_FALSE(show(0.7, 60ms));
}

// Once a prediction was exceeded, nothing is pressed any more, and the retreat is still allowed.
TEST(ForcePrediction, TheFirstThatIsExceededIsTheLastOne) {
  WatchedFrame frame;
  frame.apply(to_input(permit_to_force(frame.rig, 0.5, 0.1e-3).value()));
  WatchInputEvent end(WatchInput::compared);
  end.reason = "target";
  end.force_N = 19;
  end.noise_N = kNoise_N;
  ASSERT_TRUE(frame.apply(end).compared);
  const auto no = permit_to_force(frame.rig, 0.5, 0.01e-3);
  ASSERT_FALSE(no);
  EXPECT_EQ(no.error().code, Errc::limit_tripped);
  EXPECT_NE(no.error().what.find("nothing is pressed any more"), std::string::npos);
  frame.rig.frame.seen.travel_m = 10e-3;
  EXPECT_TRUE(permit_to_travel(frame.rig, 5e-3, 1e-3));
  EXPECT_FALSE(permit_to_travel(frame.rig, 15e-3, 1e-3));
}

}  // namespace
}  // namespace lcrig
