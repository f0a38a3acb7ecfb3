// SPDX-License-Identifier: Apache-2.0
// Results against force and time in synthetic runs whose truth is known: dynamic range, hysteresis,
// creep.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/unit/analysis/analysed.hpp"

namespace lcrig {
namespace {

TEST(Analyse, DynamicRangeIsNotPulledUpByNoise) {
  // 60 fF of noise on a change of 172 fF: the largest reading of a cycle would be far too large.
  SyntheticRun::Dynamic d;
  d.noise_F = 60e-15;
  d.cycles = 40;
  d.branch_s = 1;
  const auto a = of_dynamic(d);
  ASSERT_EQ(a.cycles.size(), 40U);
  const double truth = 2.15e-15 * 79.577 / 3.65e-12 * 100;
  EXPECT_TRUE(holds(a.dynamic_range, truth)) << a.dynamic_range.value();
  EXPECT_NEAR(a.dynamic_range.value(), truth, 3 * *a.dynamic_range.estimate->standard_error);
  EXPECT_LT(*a.dynamic_range.estimate->standard_error, 0.3);
  EXPECT_FALSE(a.hysteresis.resolved);
}

// A fit up to the largest force that a noisy cell showed would scatter by more than the readings.
TEST(Analyse, AHoldOfASecondAtTheLargestForceIsAPlateau) {
  SyntheticRun run;
  run.reading_s = 0.065;
  run.begin();
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  const auto stay = [&](double force_N, int readings) {
    for (int i = 0; i < readings; ++i) {
      run.reading(3.65e-12 + 400e-15 * force_N + 0.6e-15 * normal(random),
                  force_N + 0.0005 * normal(random));
    }
  };
  stay(0, 100);
  for (int cycle = 0; cycle < 4; ++cycle) {
    for (const double force_N : {0.25, 0.5, 0.75, 1.0}) stay(force_N, 15);
    stay(0.5, 1);
    stay(0, 60);
  }
  run.end();
  const auto a = analysed(run);
  ASSERT_EQ(a.cycles.size(), 4U);
  for (const CycleResult& c : a.cycles) {
    EXPECT_EQ(c.peak_method, PeakMethod::plateau);
    EXPECT_NEAR(c.delta_C_fF, 400, 4 * 0.6 / std::sqrt(15.0));
  }
}

TEST(Analyse, FindsHysteresisAndItsArea) {
  SyntheticRun::Dynamic d;
  d.noise_F = 1e-15;
  d.branch_s = 20;
  // Unloading lies above: 4 h u (1 - u) of the span of 172 fF, at most 17 fF in the middle.
  d.capacitance_F = [](double kPa, bool up) {
    const double u = kPa / 79.577;
    return 3.65e-12 + 171.1e-15 * (u + (up ? 0 : 0.4 * u * (1 - u)));
  };
  const auto a = of_dynamic(d);
  EXPECT_NEAR(a.hysteresis.largest_gap.value(), 10, 0.4);
  EXPECT_TRUE(a.hysteresis.resolved);
  EXPECT_NEAR(a.hysteresis.area.value(), 0.4 / 6 * 100, 1.2);  // over 10 to 95 % of the force
}

TEST(Analyse, AFastLoopWithoutHysteresisIsNotCalledHysteresis) {
  SyntheticRun::Dynamic d;
  d.noise_F = 0.1e-15;
  d.branch_s = 2;
  const auto a = of_dynamic(d);
  EXPECT_LT(a.hysteresis.largest_gap.value(), 0.5);
  EXPECT_GT(*a.hysteresis.uncorrected_percent, 1) << "the force at the reading's arrival";
  EXPECT_FALSE(a.hysteresis.resolved);
}

TEST(Analyse, CreepUnderAHeldLoadHasItsTimeConstant) {
  SyntheticRun run;
  run.begin();
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) run.reading(3.65e-12 + 1e-15 * normal(random), 0);
  const double begin = run.t_s;
  while (run.t_s < begin + 60) {
    const double t = run.t_s + 0.06 - begin;
    run.reading(3.65e-12 + 300e-15 - 30e-15 * std::exp(-t / 8) + 1e-15 * normal(random), 0.5);
  }
  for (int i = 0; i < 50; ++i) run.reading(3.65e-12 + 1e-15 * normal(random), 0);
  run.end();
  const auto a = analysed(run);
  ASSERT_EQ(a.holds.size(), 1U);
  EXPECT_TRUE(a.holds[0].resolved);
  EXPECT_NEAR(*a.holds[0].time_constant_s, 8, 1);
  EXPECT_NEAR(a.settling.value(), 8 * std::log(30 / (0.02 * 300)), 2);
  EXPECT_GT(a.creep.value(), 2);
}

// Holds of 300 fF, each with an exponential of this size in fF.
RunAnalysis of_holds(const std::vector<double>& creep_fF) {
  SyntheticRun run;
  run.begin();
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) run.reading(3.65e-12 + 1e-15 * normal(random), 0);
  for (const double size : creep_fF) {
    const double begin = run.t_s;
    while (run.t_s < begin + 30) {
      const double creep = size * 1e-15 * std::exp(-(run.t_s + 0.06 - begin) / 4);
      run.reading(3.65e-12 + 300e-15 - creep + 1e-15 * normal(random), 0.5);
    }
    for (int i = 0; i < 50; ++i) run.reading(3.65e-12 + 1e-15 * normal(random), 0);
  }
  run.end();
  return analysed(run);
}

TEST(Analyse, SettlingIsNotAZeroWhereItIsNotResolved) {
  const auto within = of_holds({5, 5, 5});  // 6 fF are 2 % of the change from rest
  ASSERT_EQ(within.holds.size(), 3U);
  EXPECT_TRUE(within.holds[0].resolved);
  EXPECT_FALSE(within.holds[0].settling_s);
  EXPECT_FALSE(within.settling) << within.settling.value();
  EXPECT_NE(within.settling.reason.find("not resolved: 0 of 3"), std::string::npos);
  EXPECT_FALSE(of_holds({0, 0, 0, 30}).settling) << "one of four may be chance";
  const auto all = of_holds({30, 30, 30});
  ASSERT_TRUE(all.settling) << all.settling.reason;
  EXPECT_NEAR(all.settling.value(), 4 * std::log(30.0 / 6), 2);
}

TEST(Analyse, NoCreepIsNotCalledCreep) {
  const auto a = of_static(SyntheticRun::Static());
  EXPECT_EQ(a.holds.size(), 40U);
  EXPECT_TRUE(holds(a.creep, 0) ||
              std::abs(a.creep.value()) < 3 * *a.creep.estimate->standard_error);
  EXPECT_FALSE(a.settling);
}

// The paper's slopes and dynamic ranges must survive storage, alignment, analysis and comparison.
TEST(Analyse, GivesThePapersDynamicRangesBack) {
  int i = 0;
  for (const double percent : {4.7, 10.4, 32.4}) {
    SyntheticRun::Dynamic d;
    d.seed = static_cast<std::uint64_t>(21 + i);
    const double c0 = 3.65e-12 * ++i;
    d.noise_F = 20e-15;
    d.capacitance_F = [=](double kPa, bool) { return c0 * (1 + percent / 100 * kPa / 79.577); };
    const auto a = of_dynamic(d);
    EXPECT_TRUE(holds(a.dynamic_range, percent))
        << percent << " as " << a.dynamic_range.value() << " +- "
        << *a.dynamic_range.estimate->standard_error;
  }
}

}  // namespace
}  // namespace lcrig
