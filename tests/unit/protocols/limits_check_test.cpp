// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/support/watched_frame.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

FrameSample sample(double t_s, std::optional<double> force_N) {
  FrameSample s;
  s.received = MonoTime() + from_seconds(t_s);
  s.force_N = force_N;
  s.travel_m = 0;
  return s;
}

// The limits of a run over a frame that others move: only its samples are judged.
class Guarded {
 public:
  explicit Guarded(const BoundLimits& limits, ForceClass cell = kAssumedForceClass)
      : rig(facts(limits, cell), std::nullopt) {}
  bool check(const FrameSample& sample) {
    const auto compared = rig.apply(sample);
    const auto found = find(rig, Sight{sample, compared});
    return most_severe(found) != nullptr;
  }
  bool check_age(MonoTime now) const { return find_silence(rig, now).has_value(); }
  void apply(WatchInput what, std::optional<double> force_N = std::nullopt, double noise_N = 0) {
    WatchInputEvent e(what);
    e.force_N = force_N;
    e.travel_m = force_N;
    e.noise_N = noise_N;
    e.on = true;
    rig.apply(e, nullptr, MonoTime());
  }
  RigState rig;

 private:
  static RigFacts facts(const BoundLimits& limits, ForceClass cell) {
    RigFacts facts = watched_facts();
    facts.commands = false;
    facts.limits = limits;
    facts.cell = cell;
    return facts;
  }
};

BoundLimits window() {
  BoundLimits w;
  w.force_min_N = -0.2;
  w.force_max_N = 1;
  return w;
}

TEST(Limits, SamplesWithoutAForceAreNoSamples) {
  Guarded guard(window());
  guard.apply(WatchInput::age_watched);
  EXPECT_FALSE(guard.check(sample(1.0, 0.1)));
  EXPECT_FALSE(guard.check(sample(1.4, std::nullopt)));
  EXPECT_FALSE(guard.check_age(MonoTime() + 1400ms));
  EXPECT_FALSE(guard.check(sample(1.6, std::nullopt)));
  EXPECT_TRUE(guard.check_age(MonoTime() + 1600ms)) << "the force is not known for 0.6 s";
}

TEST(Limits, AForceBeyondTheCellStopsAtOnce) {
  Guarded guard(window());
  FrameSample s = sample(1, std::nullopt);
  s.flags = frame_flag::kForceOverload;
  EXPECT_TRUE(guard.check(s));
}

TEST(Limits, ASpikeInEitherDirectionIsSeen) {
  Guarded guard(window());
  EXPECT_FALSE(guard.check(sample(1, 1.0)));
  EXPECT_TRUE(guard.check(sample(1, 1.01)));
  EXPECT_TRUE(guard.check(sample(1, -0.21)));
}

FrameSample seen(double force_N, double travel_m) {
  FrameSample s = sample(1, force_N);
  s.travel_m = travel_m;
  return s;
}

FrameSample overload(double travel_m) {
  FrameSample s = sample(1, std::nullopt);
  s.travel_m = travel_m;
  s.flags = frame_flag::kForceOverload;
  return s;
}

// A guard in a motion that went beyond the limit, was stopped and is on its way back.
Guarded returning(double peak_N, double stood_m, ForceClass cell = kAssumedForceClass) {
  Guarded guard(window(), cell);
  EXPECT_TRUE(guard.check(seen(1.1, stood_m - 2e-6)));
  guard.apply(WatchInput::stopping);
  EXPECT_FALSE(guard.check(seen(peak_N, stood_m))) << "until it stands nothing is news";
  guard.apply(WatchInput::retreat, std::nullopt, 0.002);
  return guard;
}

TEST(Limits, OnTheWayBackAnyForceIsAllowedThatDoesNotRise) {
  Guarded guard = returning(2.5, 1e-3);
  EXPECT_FALSE(guard.check(seen(2.5, 1e-3)));
  EXPECT_FALSE(guard.check(seen(2.505, 1e-3))) << "noise";
  EXPECT_FALSE(guard.check(seen(1.4, 0.99e-3)));
  EXPECT_TRUE(guard.check(seen(2.6, 0.99e-3)));
}

TEST(Limits, OnTheWayBackTheForceMayRiseByTheClassOfTheCell) {
  for (const double percent : kForceClasses) {
    const double noise_N = kSampleSigmas * 0.002;
    Guarded guard = returning(2.5, 1e-3, ForceClass(percent));
    EXPECT_FALSE(guard.check(seen(2.5 * (1 + 0.99 * percent / 100) + noise_N, 1e-3))) << percent;
    EXPECT_TRUE(guard.check(seen(2.5 * (1 + 1.01 * percent / 100) + noise_N, 1e-3))) << percent;
  }
}

TEST(Limits, OnTheWayBackTheSpecimenMayNotBePulledAt) {
  Guarded guard = returning(2.5, 1e-3);
  EXPECT_TRUE(guard.check(seen(-0.25, 0.9e-3)));
}

TEST(Limits, OnTheWayBackWithoutAForceOnlyLessTravelIsAllowed) {
  Guarded guard = returning(2.5, 1e-3);
  EXPECT_FALSE(guard.check(overload(1e-3)));
  EXPECT_FALSE(guard.check(overload(0.9e-3)));
  EXPECT_TRUE(guard.check(overload(1.02e-3)));
}

TEST(Limits, OnTheWayBackACellThatFellSilentNeedsOnlyTravelThatLeadsAway) {
  Guarded guard(window());
  guard.apply(WatchInput::age_watched);
  const auto mute = [](double t_s, double travel_m) {
    FrameSample s = sample(t_s, std::nullopt);
    s.travel_m = travel_m;
    return s;
  };
  EXPECT_FALSE(guard.check(sample(1, 0.5)));
  guard.apply(WatchInput::stopping);
  guard.apply(WatchInput::retreat, std::nullopt, 1e-3);
  for (double t_s = 1.1; t_s < 3; t_s += 0.1) {
    EXPECT_FALSE(guard.check(mute(t_s, -1e-3 * (t_s - 1)))) << t_s;
    EXPECT_FALSE(guard.check_age(MonoTime() + from_seconds(t_s + 0.05))) << t_s;
  }
  EXPECT_TRUE(guard.check(mute(3.1, 1e-3))) << "towards the specimen";
  EXPECT_TRUE(guard.check_age(MonoTime() + 5s)) << "no travel either";
}

TEST(Limits, ATravelBeyondItsLimitIsAWayBackToo) {
  BoundLimits w = window();
  w.travel_min_m = -1e-3;
  w.travel_max_m = 1e-3;
  Guarded guard(w);
  EXPECT_TRUE(guard.check(seen(0, 1.05e-3)));
  guard.apply(WatchInput::stopping);
  EXPECT_FALSE(guard.check(seen(0, 1.1e-3)));
  guard.apply(WatchInput::retreat, std::nullopt, 0);
  EXPECT_FALSE(guard.check(seen(0, 1.1e-3)));
  EXPECT_FALSE(guard.check(seen(0, 0.5e-3)));
  EXPECT_TRUE(guard.check(seen(0, 1.2e-3)));
}

TEST(Limits, ASpecimenThatHoldsOnToTheProbeIsPulled) {
  Guarded guard(window());
  guard.check(seen(-0.1, 0));
  EXPECT_FALSE(guard.rig.stood_pulled());
  guard.check(seen(-0.3, 0));
  EXPECT_TRUE(guard.rig.stood_pulled());
}

TEST(Limits, GapLimitsCountFromContactOn) {
  BoundLimits w = window();
  w.gap_min_m = -0.5e-3;
  w.gap_max_m = 10e-3;
  w.travel_max_m = 35e-3;
  w.travel_min_m = 0;
  Guarded guard(w);
  EXPECT_FALSE(guard.check(seen(0, 5e-3)));
  guard.apply(WatchInput::contact, 30e-3);
  EXPECT_TRUE(guard.check(seen(0, 19.9e-3)));
  EXPECT_FALSE(guard.check(seen(0, 20.1e-3)));
  EXPECT_TRUE(guard.check(seen(0, 30.6e-3)));
}

TEST(Limits, WhatTheCellShowsBelowZeroAtRestIsNoRoom) {
  Guarded guard(window());
  guard.apply(WatchInput::zero, -0.1, 0.001);
  EXPECT_TRUE(guard.check(sample(1, 0.95)));
  guard.apply(WatchInput::zero, -0.004, 0.001);
  EXPECT_FALSE(guard.check(sample(1, 0.95)));
}

TEST(Limits, TravelThatIsNotSentAnyMoreStopsAMotion) {
  Guarded guard(window());
  guard.apply(WatchInput::age_watched);
  EXPECT_FALSE(guard.check(sample(1, 0.1)));
  FrameSample blind = sample(1.9, 0.1);
  blind.travel_m.reset();
  EXPECT_FALSE(guard.check(blind)) << "a value may be missing now and then";
  blind.received += 200ms;
  EXPECT_TRUE(guard.check(blind));
}

TEST(Limits, AfterAZeroOfSomebodyElseOnlyTheWayAwayCounts) {
  Guarded guard(window());
  EXPECT_FALSE(guard.check(sample(1, 0.9)));
  guard.apply(WatchInput::force_invalid);
  guard.apply(WatchInput::stopping);
  guard.apply(WatchInput::retreat, std::nullopt, 0.001);
  FrameSample away = sample(2, -0.5);
  away.travel_m = -1e-3;
  EXPECT_FALSE(guard.check(away)) << "the force means nothing any more";
  FrameSample deeper = sample(3, 0.1);
  deeper.travel_m = 1e-3;
  EXPECT_TRUE(guard.check(deeper));
}

}  // namespace
}  // namespace lcrig
