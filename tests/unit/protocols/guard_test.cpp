// SPDX-License-Identifier: Apache-2.0
#include "protocols/watch/guard.hpp"

#include <gtest/gtest.h>

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

BoundLimits window() {
  BoundLimits w;
  w.force_min_N = -0.2;
  w.force_max_N = 1;
  return w;
}

TEST(Guard, SamplesWithoutAForceAreNoSamples) {
  Guard guard(window(), 500ms, kAssumedForceClass);
  guard.set_watch_age(true);
  EXPECT_FALSE(guard.check(sample(1.0, 0.1)));
  EXPECT_FALSE(guard.check(sample(1.4, std::nullopt)));
  EXPECT_FALSE(guard.check_age(MonoTime() + 1400ms));
  EXPECT_FALSE(guard.check(sample(1.6, std::nullopt)));
  EXPECT_TRUE(guard.check_age(MonoTime() + 1600ms)) << "the force is not known for 0.6 s";
}

TEST(Guard, AForceBeyondTheCellStopsAtOnce) {
  Guard guard(window(), 500ms, kAssumedForceClass);
  FrameSample s = sample(1, std::nullopt);
  s.flags = frame_flag::kForceOverload;
  EXPECT_TRUE(guard.check(s));
}

TEST(Guard, ASpikeInEitherDirectionIsSeen) {
  Guard guard(window(), 500ms, kAssumedForceClass);
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
Guard returning(double peak_N, double stood_m, ForceClass cell = kAssumedForceClass) {
  Guard guard(window(), 500ms, cell);
  EXPECT_TRUE(guard.check(seen(1.1, stood_m - 2e-6)));
  guard.expect_standstill();
  EXPECT_FALSE(guard.check(seen(peak_N, stood_m))) << "until it stands nothing is news";
  guard.allow_return(0.002);
  return guard;
}

TEST(Guard, OnTheWayBackAnyForceIsAllowedThatDoesNotRise) {
  Guard guard = returning(2.5, 1e-3);
  EXPECT_FALSE(guard.check(seen(2.5, 1e-3)));
  EXPECT_FALSE(guard.check(seen(2.505, 1e-3))) << "noise";
  EXPECT_FALSE(guard.check(seen(1.4, 0.99e-3)));
  EXPECT_TRUE(guard.check(seen(2.6, 0.99e-3)));
}

TEST(Guard, OnTheWayBackTheForceMayRiseByTheClassOfTheCell) {
  for (const double percent : kForceClasses) {
    const double noise_N = kSampleSigmas * 0.002;
    Guard guard = returning(2.5, 1e-3, ForceClass(percent));
    EXPECT_FALSE(guard.check(seen(2.5 * (1 + 0.99 * percent / 100) + noise_N, 1e-3))) << percent;
    EXPECT_TRUE(guard.check(seen(2.5 * (1 + 1.01 * percent / 100) + noise_N, 1e-3))) << percent;
  }
}

TEST(Guard, OnTheWayBackTheSpecimenMayNotBePulledAt) {
  Guard guard = returning(2.5, 1e-3);
  EXPECT_TRUE(guard.check(seen(-0.25, 0.9e-3)));
}

TEST(Guard, OnTheWayBackWithoutAForceOnlyLessTravelIsAllowed) {
  Guard guard = returning(2.5, 1e-3);
  EXPECT_FALSE(guard.check(overload(1e-3)));
  EXPECT_FALSE(guard.check(overload(0.9e-3)));
  EXPECT_TRUE(guard.check(overload(1.02e-3)));
}

TEST(Guard, OnTheWayBackACellThatFellSilentNeedsOnlyTravelThatLeadsAway) {
  Guard guard(window(), 500ms, kAssumedForceClass);
  guard.set_watch_age(true);
  const auto mute = [](double t_s, double travel_m) {
    FrameSample s = sample(t_s, std::nullopt);
    s.travel_m = travel_m;
    return s;
  };
  EXPECT_FALSE(guard.check(sample(1, 0.5)));
  guard.expect_standstill();
  guard.allow_return(1e-3);
  for (double t_s = 1.1; t_s < 3; t_s += 0.1) {
    EXPECT_FALSE(guard.check(mute(t_s, -1e-3 * (t_s - 1)))) << t_s;
    EXPECT_FALSE(guard.check_age(MonoTime() + from_seconds(t_s + 0.05))) << t_s;
  }
  EXPECT_TRUE(guard.check(mute(3.1, 1e-3))) << "towards the specimen";
  EXPECT_TRUE(guard.check_age(MonoTime() + 5s)) << "no travel either";
}

TEST(Guard, ATravelBeyondItsLimitIsAWayBackToo) {
  BoundLimits w = window();
  w.travel_min_m = -1e-3;
  w.travel_max_m = 1e-3;
  Guard guard(w, 500ms, kAssumedForceClass);
  EXPECT_TRUE(guard.check(seen(0, 1.05e-3)));
  guard.expect_standstill();
  EXPECT_FALSE(guard.check(seen(0, 1.1e-3)));
  guard.allow_return(0);
  EXPECT_FALSE(guard.check(seen(0, 1.1e-3)));
  EXPECT_FALSE(guard.check(seen(0, 0.5e-3)));
  EXPECT_TRUE(guard.check(seen(0, 1.2e-3)));
}

TEST(Guard, ASpecimenThatHoldsOnToTheProbeIsPulled) {
  Guard guard(window(), 500ms, kAssumedForceClass);
  guard.check(seen(-0.1, 0));
  EXPECT_FALSE(guard.is_pulled());
  guard.check(seen(-0.3, 0));
  EXPECT_TRUE(guard.is_pulled());
}

TEST(Guard, GapLimitsCountFromContactOn) {
  BoundLimits w = window();
  w.gap_min_m = -0.5e-3;
  w.gap_max_m = 10e-3;
  w.travel_max_m = 35e-3;
  w.travel_min_m = 0;
  Guard guard(w, 500ms, kAssumedForceClass);
  EXPECT_FALSE(guard.check(seen(0, 5e-3)));
  guard.place_contact(30e-3);
  EXPECT_TRUE(guard.check(seen(0, 19.9e-3)));
  EXPECT_FALSE(guard.check(seen(0, 20.1e-3)));
  EXPECT_TRUE(guard.check(seen(0, 30.6e-3)));
}

TEST(Guard, WhatTheCellShowsBelowZeroAtRestIsNoRoom) {
  Guard guard(window(), 500ms, kAssumedForceClass);
  guard.set_rest_force(-0.1, 0.001);
  EXPECT_TRUE(guard.check(sample(1, 0.95)));
  guard.set_rest_force(-0.004, 0.001);
  EXPECT_FALSE(guard.check(sample(1, 0.95)));
}

TEST(Guard, TravelThatIsNotSentAnyMoreStopsAMotion) {
  Guard guard(window(), 500ms, kAssumedForceClass);
  guard.set_watch_age(true);
  EXPECT_FALSE(guard.check(sample(1, 0.1)));
  FrameSample blind = sample(1.9, 0.1);
  blind.travel_m.reset();
  EXPECT_FALSE(guard.check(blind)) << "a value may be missing now and then";
  blind.received += 200ms;
  EXPECT_TRUE(guard.check(blind));
}

TEST(Guard, AfterAZeroOfSomebodyElseOnlyTheWayAwayCounts) {
  Guard guard(window(), 500ms, kAssumedForceClass);
  EXPECT_FALSE(guard.check(sample(1, 0.9)));
  guard.distrust_zero(20);
  guard.expect_standstill();
  guard.allow_return(0.001);
  FrameSample away = sample(2, -0.5);
  away.travel_m = -1e-3;
  EXPECT_FALSE(guard.check(away)) << "the force means nothing any more";
  FrameSample deeper = sample(3, 0.1);
  deeper.travel_m = 1e-3;
  EXPECT_TRUE(guard.check(deeper));
}

}  // namespace
}  // namespace lcrig
