// SPDX-License-Identifier: Apache-2.0
// Levels that some or all repeats lack: which slope this is, and how well it is known.
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/unit/analysis/analysed.hpp"
#include "tests/unit/analysis/disturbed_run.hpp"

namespace lcrig {
namespace {

bool says(const std::string& text, const char* words) {
  return text.find(words) != std::string::npos;
}

// Four repeats of ten levels of a bent curve without noise.
SyntheticRun::Static bent() {
  SyntheticRun::Static s;
  s.noise_F = 0;
  s.capacitance_F = [](double kPa) { return 3.65e-12 + 8e-15 * kPa - 0.03e-15 * kPa * kPa; };
  return s;
}

// Where `is_lacking(level)` (level from 1 to 40), only the first `kept` readings are there.
template <class IsLacking>
RunAnalysis lacking(IsLacking is_lacking, int kept) {
  auto s = bent();
  s.spoil = [=](int level, int reading, double v) {
    return is_lacking(level) && reading > kept ? std::nullopt : std::optional(v);
  };
  return of_static(s);
}

void expect_same_slopes(const RunAnalysis& a, const RunAnalysis& whole) {
  for (std::size_t k = 0; k < 2; ++k) {
    const double truth = whole.ranges[k].sensitivity.value();
    EXPECT_NEAR(a.ranges[k].sensitivity.value(), truth, 1e-6) << k;
    ASSERT_TRUE(a.ranges[k].robust);
    EXPECT_NEAR(a.ranges[k].robust->slope_fF_per_kPa, truth, 1e-6) << k;
  }
}

TEST(MissingLevel, OfOneRepeatLeavesTheSlopeOfTheSameCurve) {
  const auto whole = of_static(bent());
  for (const int kept : {0, 2}) {
    SCOPED_TRACE(kept);
    const auto a = lacking([](int level) { return level == 13 || level == 30; }, kept);
    expect_same_slopes(a, whole);
    EXPECT_EQ(
        says(a.ranges[0].sensitivity.reason,
             "1 of 3 pressures are missing in some repeats: they count as much as the others"),
        kept == 0)
        << a.ranges[0].sensitivity.reason;
  }
}

TEST(MissingLevel, OfARepeatThatTheRunBrokeOffLeavesTheSlopeOfTheSameCurve) {
  const auto whole = of_static(bent());
  for (const int last : {32, 35, 38}) {
    SCOPED_TRACE(last);
    expect_same_slopes(lacking([last](int level) { return level > last; }, 0), whole);
  }
}

TEST(MissingLevel, OfAllRepeatsIsNamedInTheRun) {
  const auto whole = of_static(bent());
  auto a = lacking([](int level) { return level % 10 == 5; }, 0);  // 50 kPa
  EXPECT_TRUE(says(a.ranges[1].sensitivity.reason,
                   "no reading at 50 kPa: the slope is that of the other pressures"))
      << a.ranges[1].sensitivity.reason;
  EXPECT_FALSE(says(a.ranges[0].sensitivity.reason, "no reading at"));
}

// The slopes of the repeats differ, and the last repeat has only two levels of seven. Effectively
// three repeats determine the scatter. With the degrees of freedom of four, the interval held too
// seldom.
TEST(MissingLevel, TheIntervalHoldsWhereARepeatHasTwoLevelsOfSeven) {
  constexpr int kRuns = 150;
  int held = 0;
  AnalysisOptions options;
  options.ranges = {{0, 100}};
  for (int k = 0; k < kRuns; ++k) {
    std::mt19937_64 random(4400 + static_cast<std::uint64_t>(k));
    std::normal_distribution<double> slope(1, 0.02);
    Disturbed d;
    d.slopes = {slope(random), slope(random), slope(random), slope(random)};
    DisturbedRun run(d, 9100 + static_cast<std::uint64_t>(k));
    for (RunReading& r : run.data.readings) {
      if (r.repeat == 4 && r.level > 23) r.level = r.index = 0;
    }
    const auto a = analyse(run.data, options);
    ASSERT_TRUE(a);
    held += holds(a->ranges[0].sensitivity, 7.5) ? 1 : 0;
  }
  EXPECT_GE(held, 0.92 * kRuns);
  EXPECT_LE(held, 0.99 * kRuns);
}

}  // namespace
}  // namespace lcrig
