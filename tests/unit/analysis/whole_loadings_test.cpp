// SPDX-License-Identifier: Apache-2.0
// Loadings that differ from the others: broken off, lower on purpose, or of a softened specimen.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/analysis/analysed.hpp"

namespace lcrig {
namespace {

constexpr double kC0_F = 3.65e-12;

SyntheticRun::Dynamic cycles_to(double peak_N, int cycles) {
  SyntheticRun::Dynamic d;
  d.noise_F = 0.5e-15;
  d.branch_s = 4;
  d.peak_N = peak_N;
  d.cycles = cycles;
  return d;
}

// Dynamic range of the straight specimen of SyntheticRun::Dynamic.
double percent_of(double peak_N) {
  return 2.15e-15 * peak_N / SyntheticRun::area_m2() * 1e-3 / kC0_F * 100;
}

// The force grows to `force_N`, and nothing more is recorded.
void break_off_at(SyntheticRun& run, double force_N) {
  const double begin_s = run.t_s;
  const auto force = [begin_s](double t) { return (t - begin_s) / 4; };
  while (force(run.t_s) < force_N) {
    const double middle_N = force(run.t_s + run.reading_s / 2);
    run.reading(kC0_F * (1 + percent_of(middle_N) / 100), force);
  }
}

RunAnalysis broken_off_at(double force_N, ExitStatus status) {
  SyntheticRun run;
  run.reading_s = 0.065;
  run.begin();
  run.play(cycles_to(1, 4));
  break_off_at(run, force_N);
  run.end(status);
  return analysed(run);
}

bool says(const Metric& m, const char* words) {
  return m.reason.find(words) != std::string::npos;
}

TEST(WholeLoadings, ALoadingThatTheRunBrokeOffIsNoCycle) {
  for (const double force_N : {0.3, 0.6, 0.95}) {
    SCOPED_TRACE(force_N);
    const auto a = broken_off_at(force_N, ExitStatus::fail);
    ASSERT_EQ(a.cycles.size(), 4U);
    ASSERT_EQ(a.left_out.size(), 1U);
    EXPECT_EQ(a.left_out.front().number, 5);
    EXPECT_NEAR(a.dynamic_range.value(), percent_of(1), 0.02);
    EXPECT_TRUE(holds(a.mullins, 0)) << a.mullins.value();
    EXPECT_LT(std::abs(a.mullins.value()), 1);
    EXPECT_NEAR(a.force_sensitivity.value(), percent_of(1) / 100 * kC0_F * 1e15, 1);
    for (const Metric* m : {&a.dynamic_range, &a.dynamic_range_drift, &a.mullins,
                            &a.force_sensitivity, &a.hysteresis.largest_gap}) {
      EXPECT_TRUE(says(*m, "loading 5 left out: the run ended inside it")) << m->name << m->reason;
    }
  }
}

TEST(WholeLoadings, ALoadingThatEndedAtItsPeakCounts) {
  const auto a = broken_off_at(1, ExitStatus::fail);
  EXPECT_EQ(a.cycles.size(), 5U);
  EXPECT_EQ(a.dynamic_range.reason, "");
}

TEST(WholeLoadings, ARepeatThatTheRunBrokeOffIsNoCycle) {
  SyntheticRun run;
  run.begin();
  SyntheticRun::Static s;
  s.noise_F = 0.5e-15;
  s.repeats = 3;
  run.play(s);
  s.repeats = 1;
  s.baseline = 0;
  s.kPa = {10, 20, 30, 40, 50, 60};
  run.play(s);
  run.end(ExitStatus::fail);
  const auto a = analysed(run);
  ASSERT_EQ(a.cycles.size(), 3U);
  EXPECT_NEAR(a.dynamic_range.value(), 600 / 3650.0 * 100, 0.02);
  EXPECT_LT(std::abs(a.mullins.value()), 1);
  EXPECT_TRUE(says(a.dynamic_range, "loading 4 left out: the run ended inside it"));
}

TEST(WholeLoadings, TheDynamicRangeIsThatOfTheHighestPeaks) {
  SyntheticRun run;
  run.reading_s = 0.065;
  run.begin();
  for (const double peak_N : {0.4, 0.7, 1.0}) {
    auto d = cycles_to(peak_N, 2);
    if (peak_N > 0.4) d.baseline_s = 0;
    run.play(d);
  }
  run.end();
  const auto a = analysed(run);
  ASSERT_EQ(a.cycles.size(), 2U);
  EXPECT_NEAR(a.dynamic_range.value(), percent_of(1), 0.02);
  EXPECT_TRUE(
      says(a.dynamic_range, "4 of 6 loadings (1, 2, 3, 4) left out: their peaks of 0.4 to "))
      << a.dynamic_range.reason;
}

// The machine is 3 mm from its zero, and the specimen yields 10 um.
RunAnalysis of_peaks(const std::vector<double>& peaks_N, bool same_travel) {
  SyntheticRun run;
  run.reading_s = 0.065;
  run.begin();
  for (std::size_t k = 0; k < peaks_N.size(); ++k) {
    auto d = cycles_to(peaks_N[k], 1);
    if (k > 0) d.baseline_s = 0;
    const double um_per_N = 10 / (same_travel ? peaks_N[k] : 1);
    run.travel_m = [um_per_N](double force_N) { return 3e-3 + um_per_N * 1e-6 * force_N; };
    run.play(d);
  }
  run.end();
  return analysed(run);
}

TEST(WholeLoadings, ASpecimenThatSoftensAtEqualTravelKeepsItsCycles) {
  const auto a = of_peaks({1, 0.85, 0.8, 0.75, 0.75}, true);
  EXPECT_EQ(a.cycles.size(), 5U);
  ASSERT_TRUE(a.mullins);
  EXPECT_NEAR(a.mullins.value(), 25, 1);
  EXPECT_EQ(a.mullins.reason, "of the peak force at equal travel");
}

TEST(WholeLoadings, TravelIsEqualSinceContactAndNotSinceTheMachinesZero) {
  const auto a = of_peaks({1, 0.97, 0.94, 0.91}, false);
  EXPECT_EQ(a.cycles.size(), 4U);
  EXPECT_FALSE(a.mullins);
  EXPECT_TRUE(says(a.mullins, "neither the same peak force nor the same peak travel"));
}

}  // namespace
}  // namespace lcrig
