// SPDX-License-Identifier: Apache-2.0
// Readings whose window reaches over the peak of a cycle. A meter gives the mean over its window;
// on a branch that is the value in the middle, across the turn it is less.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "analysis/analysis.hpp"
#include "tests/support/synthetic_run.hpp"

namespace lcrig {
namespace {

// A straight specimen, 80 kPa in a second, a window of a tenth of that.
RunAnalysis of_mean_windows(double reading_s) {
  SyntheticRun run;
  run.reading_s = reading_s;
  run.begin();
  SyntheticRun::Dynamic d;
  d.cycles = 20;
  d.branch_s = 1;
  d.rest_s = 1;
  d.baseline_s = 5;
  d.anywhere = true;
  d.noise_F = 0.1e-15;
  d.window_points = 40;
  run.play(d);
  run.end();
  auto out = analyse(run.db(), run.run());
  EXPECT_TRUE(out) << (out ? "" : out.error().what);
  return out ? std::move(*out) : RunAnalysis();
}

double size_of(const std::vector<Uncertainty>& budgets, const std::string& quantity,
               const std::string& name) {
  for (const Uncertainty& b : budgets) {
    if (b.quantity != quantity) continue;
    for (const UncertaintyPart& p : b.parts) {
      if (p.name == name) return p.standard_uncertainty;
    }
  }
  return std::nan("");
}

TEST(TurningPoint, AReadingAcrossItBelongsToNoBranch) {
  for (const double reading_s : {0.065, 0.12}) {
    const auto a = of_mean_windows(reading_s);
    ASSERT_EQ(a.cycles.size(), 20U);
    ASSERT_EQ(a.ranges.size(), 2U);
    EXPECT_NEAR(a.ranges[0].sensitivity.value() / 2.15, 1, 2e-3) << reading_s;
    EXPECT_NEAR(a.ranges[1].sensitivity.value() / 2.15, 1, 2e-3) << reading_s;
    EXPECT_NEAR(a.force_sensitivity.value() / (2.15 * 79.577), 1, 2e-3) << reading_s;
    double peak_kPa = 0;  // between two samples of the frame the force is a little larger
    for (const CycleResult& c : a.cycles) peak_kPa += *c.peak_kPa / 20;
    const double range = 2.15e-3 * peak_kPa / 3.65 * 100;
    const double turn = size_of(a.uncertainties, "dynamic range", "turn within a window");
    EXPECT_NEAR(turn / range, reading_s / 12, 0.1 * reading_s / 12) << reading_s;
    EXPECT_NEAR(a.dynamic_range.value(), range, 2 * turn) << reading_s;
    EXPECT_FALSE(a.hysteresis.resolved) << reading_s;
  }
}

// Were the moving force taken for noise of the cell, readings under load would count as unloaded.
TEST(TurningPoint, ALoadingIsNoNoiseOfTheForce) {
  const auto a = of_mean_windows(0.065);
  ASSERT_EQ(a.cycles.size(), 20U);
  for (const CycleResult& c : a.cycles) EXPECT_NEAR(c.rest_pF, 3.65, 1e-3) << c.number;
}

// One error of the instant in all readings: the pressure moves by its rate, and the rate grows as
// the specimen stiffens.
TEST(TurningPoint, TheErrorOfTheInstantStandsInTheBudgetOfASlope) {
  const auto a = of_mean_windows(0.12);
  ASSERT_EQ(a.ranges.size(), 2U);
  for (const RangeResult& r : a.ranges) {
    EXPECT_NEAR(r.instant_s, std::hypot(0.12, 0.02) / std::sqrt(12), 1e-4);
    EXPECT_NEAR(r.rate_tilt_per_s, 0, 0.05) << "the force grows evenly";
    const bool told =
        std::any_of(r.uncertainty.parts.begin(), r.uncertainty.parts.end(),
                    [](const UncertaintyPart& p) { return p.name == "alignment of the clocks"; });
    EXPECT_TRUE(told);
  }
}

}  // namespace
}  // namespace lcrig
