// SPDX-License-Identifier: Apache-2.0
// Runs that lack something: each result says what it cannot know.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/unit/analysis/analysed.hpp"

namespace lcrig {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

// 20, 40 and 60 kPa in each repeat, ten readings a level. Nothing is read between the repeats.
void play_without_rests(SyntheticRun& run, int repeats) {
  for (int i = 0; i < 20; ++i) run.reading(3.65e-12 + (i % 3) * 1e-15, 0);
  run.event("contact", R"({"travel_m":0.003,"force_N":0.02,"rest_force_N":0})");
  for (int repeat = 1; repeat <= repeats; ++repeat) {
    for (int k = 1; k <= 3; ++k) {
      const double force_N = k * 20e3 * SyntheticRun::area_m2();
      run.level(repeat, k, 20.0 * k, 10);
      for (int i = 0; i < 10; ++i) {
        run.reading(3.65e-12 + k * 120e-15 + ((i + repeat) % 3) * 1e-15, force_N);
      }
      run.end_level();
    }
    run.t_s += 2;
    run.frame_until(run.t_s, [](double) { return 0.0; });
  }
}

TEST(Unknowable, DriftOfARunWithoutRests) {
  SyntheticRun run;
  run.begin();
  play_without_rests(run, 3);
  run.end();
  const auto a = analysed(run);
  EXPECT_THAT(a.notes, Contains(HasSubstr("no two stretches without load")));
  EXPECT_THAT(a.drift.reason, HasSubstr("it takes two stretches without load"));
  EXPECT_TRUE(a.ranges[1].sensitivity) << a.ranges[1].sensitivity.reason;
}

TEST(Unknowable, DifferencesBetweenRepeatsOfTheOnlyOne) {
  SyntheticRun run;
  run.begin();
  play_without_rests(run, 1);
  run.end();
  const auto a = analysed(run);
  for (const Metric* m : {&a.ranges[1].sensitivity, &a.limit_of_detection}) {
    EXPECT_THAT(m->reason, HasSubstr("knows nothing of what differs between repeats")) << m->name;
  }
  EXPECT_THAT(a.repeatability_2sigma.reason, HasSubstr("no level was measured in two repeats"));
  EXPECT_FALSE(a.repeatability_2sigma);
}

// One loading and one unloading with noise whose neighbours have the correlation `rho`.
RunAnalysis of_one_cycle(double rho) {
  SyntheticRun::Dynamic d;
  d.cycles = 1;
  d.noise_F = 0;
  d.branch_s = 10;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  double noise = 0;
  d.capacitance_F = [&](double kPa, bool) {
    noise = rho * noise + std::sqrt(1 - rho * rho) * normal(random);
    return 3.65e-12 + 2.15e-15 * kPa + 2e-15 * noise;
  };
  return of_dynamic(d);
}

TEST(Unknowable, DifferencesBetweenCyclesOfTheOnlyOne) {
  const auto a = of_one_cycle(0);
  for (const Metric* m : {&a.ranges[0].sensitivity, &a.force_sensitivity, &a.dynamic_range,
                          &a.hysteresis.largest_gap, &a.hysteresis.area, &a.limit_of_detection}) {
    ASSERT_TRUE(*m) << m->name;
    EXPECT_THAT(m->reason, HasSubstr("knows nothing of what differs between cycles")) << m->name;
    EXPECT_LT(*m->estimate->degrees_of_freedom, 1e4) << m->name;
  }
  SyntheticRun two;
  SyntheticRun::Dynamic d;
  d.cycles = 2;
  two.begin();
  two.play(d);
  two.end();
  const auto b = analysed(two);
  for (const Metric* m : {&b.force_sensitivity, &b.dynamic_range, &b.limit_of_detection}) {
    EXPECT_THAT(m->reason, Not(HasSubstr("knows nothing of what differs between cycles")));
  }
}

// Correlated neighbours contain less information: the variance grows by (1 + rho)/(1 - rho).
TEST(Unknowable, WhatNeighboursOfOneCycleShareWidensItsIntervals) {
  const auto white = of_one_cycle(0), shared = of_one_cycle(0.8);
  const auto wider = [](const Metric& a, const Metric& b) {
    return *b.estimate->standard_error / *a.estimate->standard_error;
  };
  EXPECT_NEAR(wider(white.force_sensitivity, shared.force_sensitivity), 3, 1.2);
  EXPECT_NEAR(wider(white.dynamic_range, shared.dynamic_range), 3, 1.2);
  EXPECT_LT(*shared.force_sensitivity.estimate->degrees_of_freedom,
            *white.force_sensitivity.estimate->degrees_of_freedom);
}

TEST(Unknowable, ShapeOfTwoLevels) {
  SyntheticRun::Static s;
  s.kPa = {10, 30};
  const auto a = of_static(s);
  EXPECT_TRUE(holds(a.ranges[0].sensitivity, 6));
  EXPECT_EQ(a.ranges[0].residual_pattern, "two pressures: a line fits always");
  EXPECT_FALSE(a.ranges[0].lack_of_fit_p);
  EXPECT_FALSE(a.ranges[0].shared) << "what all repeats share looks like shape";
  EXPECT_THAT(a.linearity.reason, HasSubstr("three different pressures"));
}

TEST(Unknowable, EverythingOfReadingsThatAreAllFlagged) {
  SyntheticRun run;
  run.begin();
  run.flags = 4;  // after_resync
  run.play(SyntheticRun::Static());
  run.end();
  const auto a = analysed(run);
  EXPECT_THAT(a.notes, Contains(HasSubstr("1380 readings are flagged")));
  EXPECT_THAT(a.notes, Contains(HasSubstr("none is left")));
  for (const Metric* m : a.metrics()) {
    EXPECT_FALSE(*m) << m->name;
    EXPECT_FALSE(m->reason.empty()) << m->name;
  }
}

TEST(Unknowable, EverythingOfAnswersThatRepeatTheOneBefore) {
  SyntheticRun run;
  run.begin();
  run.is_fresh = false;
  run.play(SyntheticRun::Static());
  run.end();
  const auto a = analyse(run.db(), run.run());
  ASSERT_FALSE(a);
  EXPECT_THAT(a.error().what, HasSubstr("all 1380 answers repeat the one before"));
}

TEST(Unknowable, NoiseOfABaselineOfThreeReadings) {
  SyntheticRun::Static s;
  s.baseline = 3;
  const auto a = of_static(s);
  ASSERT_TRUE(a.c0);
  EXPECT_LE(*a.c0.estimate->degrees_of_freedom, 2);
  EXPECT_THAT(a.c0.reason, HasSubstr("3 readings before contact"));
  EXPECT_THAT(of_static(SyntheticRun::Static()).c0.reason, Not(HasSubstr("before contact")));
  EXPECT_THAT(a.noise.reason, HasSubstr("there is no baseline"));
}

TEST(Unknowable, MullinsEffectWithinWhatCyclesDifferBy) {
  constexpr double kHeight[] = {1, 1.01, 0.985, 1.015, 0.99};
  SyntheticRun::Dynamic d;
  d.noise_F = 0.5e-15;
  int cycle = -1;
  bool was_loaded = false;
  d.capacitance_F = [&](double kPa, bool) {
    if (kPa > 0 && !was_loaded) ++cycle;
    was_loaded = kPa > 0;
    return 3.65e-12 + 2.15e-15 * kPa * kHeight[std::clamp(cycle, 0, 4)];
  };
  SyntheticRun run;
  run.begin();
  run.play(d);
  run.end();
  const auto a = analysed(run);
  ASSERT_EQ(a.cycles.size(), 5);
  EXPECT_NEAR(a.mullins.value(), 1, 0.8);
  EXPECT_TRUE(holds(a.mullins, 0)) << "the first peak is 1 % above the last by chance";
}

TEST(Unknowable, HysteresisOfACycleThatNeverUnloads) {
  SyntheticRun run;
  run.begin();
  for (int i = 0; i < 50; ++i) run.reading(3.65e-12 + (i % 3) * 1e-15, 0);
  run.event("contact", R"({"travel_m":0.003,"force_N":0.02,"rest_force_N":0})");
  const double begin_s = run.t_s;
  const auto force_N = [&](double t) { return std::min(1.0, (t - begin_s) / 10); };
  while (run.t_s < begin_s + 20) {
    run.reading(3.65e-12 + 170e-15 * force_N(run.t_s), force_N);
  }
  run.end();
  const auto a = analysed(run);
  EXPECT_FALSE(a.hysteresis.largest_gap);
  EXPECT_THAT(a.hysteresis.largest_gap.reason, HasSubstr("and 0, it takes"));
  EXPECT_THAT(a.notes, Contains(HasSubstr("no two stretches without load")));
  EXPECT_THAT(a.dynamic_range.reason, HasSubstr("one cycle: the interval knows nothing"));
}

}  // namespace
}  // namespace lcrig
