// SPDX-License-Identifier: Apache-2.0
// Checks of samples that lack a value, of a cell whose zero is not 0, and of forces that turn
// round.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "protocols/rig/prediction.hpp"
#include "tests/support/watched_frame.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

FrameSample lacking(MonoTime t, std::optional<double> travel_m, std::optional<double> force_N) {
  FrameSample s;
  s.received = t;
  s.travel_m = travel_m;
  s.force_N = force_N;
  return s;
}

// Names of the checks that find something in this sample, in the state as it is.
std::vector<std::string> found_in(const RigState& rig, const FrameSample& sample,
                                  const std::optional<ForceComparison>& compared = std::nullopt) {
  std::vector<std::string> out;
  for (const Finding& f : find(rig, Sight{sample, compared})) out.emplace_back(f.check->name);
  return out;
}

using ::testing::Contains;
using ::testing::Not;

// Each of these states is found out by a whole sample, and by none that lacks the value.
TEST(BlindSamples, AreJudgedByTheValuesThatTheyHave) {
  WatchedFrame frame;
  RigState& rig = frame.rig;
  rig.contact.travel_m = 1e-3;
  rig.contact.least.emplace(frame.t, 1e-3, 0.05, 100e3);
  frame.order(pressing(1e-5));
  rig.course.pressed.too_small = 2;
  rig.course.furthest_m = 5e-3;
  rig.frame.order.to_N = 2;
  rig.course.loop = Course::Loop{1, 0, 1e-3};
  const MonoTime t = frame.t;
  const auto whole = found_in(rig, lacking(t, 1.01e-3, 0.1));
  EXPECT_THAT(whole, Contains("force_too_small"));
  EXPECT_THAT(whole, Contains("against_order"));
  EXPECT_THAT(whole, Contains("loop_runs_away"));
  const auto mute = found_in(rig, lacking(t, 1.01e-3, std::nullopt));
  EXPECT_THAT(mute, Not(Contains("force_too_small")));
  EXPECT_THAT(mute, Contains("against_order"));
  EXPECT_THAT(mute, Not(Contains("loop_runs_away")));
  const auto lost = found_in(rig, lacking(t, std::nullopt, 0.1));
  EXPECT_THAT(lost, Not(Contains("force_too_small")));
  EXPECT_THAT(lost, Not(Contains("against_order")));
}

TEST(BlindSamples, AComparisonIsEitherALateOneOrABrokenPrediction) {
  const WatchedFrame frame;
  const FrameSample sample = lacking(frame.t, 1e-3, 0.5);
  ForceComparison compared;
  for (const bool exceeded : {false, true}) {
    compared.exceeded = exceeded;
    const auto found = found_in(frame.rig, sample, compared);
    EXPECT_EQ(std::ranges::count(found, "prediction_exceeded"), exceeded ? 1 : 0);
    EXPECT_EQ(std::ranges::count(found, "shown_late"), exceeded ? 0 : 1);
  }
}

// Before its first motion a run that commands the frame is judged by its rest measurement; one that
// only follows, or has dead weights, by the limits at once.
TEST(BlindSamples, TheLimitsCountFromTheStartWhereNothingWillMove) {
  for (const bool commands : {true, false}) {
    for (const bool motion : {true, false}) {
      RigFacts facts = watched_facts();
      facts.commands = commands;
      facts.frame.motion = motion;
      facts.limits.force_max_N = 1;
      WatchedFrame frame(round_tolerances(), facts);
      frame.rig.is_prepared = false;
      const auto found = found_in(frame.rig, lacking(frame.t, 1e-3, 1.5));
      EXPECT_EQ(found.empty(), commands && motion);
      frame.rig.is_prepared = true;
      EXPECT_FALSE(found_in(frame.rig, lacking(frame.t, 1e-3, 1.5)).empty());
    }
  }
}

// The limit lies at -0.05 N, and the unloaded cell shows `zero_N`.
struct Turned {
  explicit Turned(double zero_N) : frame(round_tolerances(), facts()) {
    frame.stand();
    frame.rig.frame.order.zero_N = zero_N;
  }
  static RigFacts facts() {
    RigFacts facts = watched_facts();
    facts.limits.force_min_N = -0.05;
    facts.limits.force_max_N = 2;
    return facts;
  }
  bool is_sign(std::optional<double> travel_m, double force_N) {
    const FrameSample s = lacking(frame.t += 20ms, travel_m, force_N);
    frame.rig.apply(s);
    const auto found = found_in(frame.rig, s);
    return std::ranges::count(found, "sign_changed") > 0;
  }
  WatchedFrame frame;
};

TEST(SignChanged, IsAboutTheForceBeyondTheZero) {
  for (const double zero_N : {-0.4, 0.0, 0.4}) {
    Turned t(zero_N);
    EXPECT_FALSE(t.is_sign(1e-3, zero_N + 1));
    EXPECT_TRUE(t.is_sign(1e-3, zero_N - 1)) << zero_N;
  }
}

TEST(SignChanged, OfASmallForceIsToldByTheFallBetweenBoth) {
  Turned t(0);  // the way of a micrometre explains 0.12 N, and the noise 0.01 N
  EXPECT_FALSE(t.is_sign(1e-3, 0.1));
  EXPECT_TRUE(t.is_sign(1e-3, -0.1)) << "by 0.2 N at once";
  Turned less(0);
  EXPECT_FALSE(less.is_sign(1e-3, 0.055));
  EXPECT_FALSE(less.is_sign(1e-3, -0.055)) << "the way explains 0.11 N";
}

TEST(SignChanged, IsNotToldWithoutBothTravelsOrOfAForceThatIsNotBelieved) {
  Turned first(0), second(0), doubted(0);
  EXPECT_FALSE(first.is_sign(std::nullopt, 1));
  EXPECT_FALSE(first.is_sign(1e-3, -1));
  EXPECT_FALSE(second.is_sign(1e-3, 1));
  EXPECT_FALSE(second.is_sign(std::nullopt, -1));
  doubted.frame.rig.trust.force = false;
  EXPECT_FALSE(doubted.is_sign(1e-3, 1));
  EXPECT_FALSE(doubted.is_sign(1e-3, -1));
}

// A force that jumps together with the travel is a frame that moved, by however little.
TEST(StandingFrame, ThatJumpsTogetherWithItsForceHasMoved) {
  for (const double way_m : {0.0, 3e-6}) {
    FrameCapabilities caps = watched_capabilities();
    caps.travel_step = Length::from_si(1e-7);
    // 5 um count as standing, a fifth of that if the force goes with it.
    WatchedFrame frame(round_tolerances(), watched_facts(caps));
    frame.stand();
    const auto jumps = [way_m](double s) {
      return s < 4 ? Place(1e-3, 1.0) : Place(1e-3 + way_m, 1.5);
    };
    ASSERT_TRUE(frame.until_found(8, jumps));
    EXPECT_EQ(frame.found->check->name, way_m > 0 ? "moves_at_standstill" : "force_jumps");
  }
}

// Five samples a second are two in each of the two intervals that are compared.
TEST(StandingFrame, ThatSendsFewSamplesIsFoundToJump) {
  WatchedFrame frame;
  frame.stand();
  std::optional<Finding> found;
  for (double s = 0; s < 8 && !found; s += 0.2) {
    found =
        frame.take(lacking(frame.t += 200ms, 1e-3, (s < 4 ? 1.0 : 1.5) + 1e-4 * std::sin(40 * s)));
  }
  ASSERT_TRUE(found);
  EXPECT_EQ(found->check->name, "force_jumps");
}

}  // namespace
}  // namespace lcrig
