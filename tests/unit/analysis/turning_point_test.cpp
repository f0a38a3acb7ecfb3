// SPDX-License-Identifier: Apache-2.0
// Readings whose window reaches over the peak of a cycle. A meter gives the mean over its window.
// On a branch this is the value in the middle; across the turn it is less.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "analysis/analysis.hpp"
#include "tests/support/synthetic_run.hpp"

namespace lcrig {
namespace {

// A straight specimen, 80 kPa in a second, and a window of a tenth of a second.
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

// If the moving force counted as noise of the cell, readings under load would count as unloaded.
TEST(TurningPoint, ALoadingIsNoNoiseOfTheForce) {
  const auto a = of_mean_windows(0.065);
  ASSERT_EQ(a.cycles.size(), 20U);
  for (const CycleResult& c : a.cycles) EXPECT_NEAR(c.rest_pF, 3.65, 1e-3) << c.number;
}

// All readings share an error of the instant. It moves the pressure in proportion to its rate,
// which grows as the specimen stiffens.
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

// An even loading of a specimen whose slope falls. All readings are later than they seem.
RunAnalysis of_late_readings(double late_s) {
  SyntheticRun run;
  run.reading_s = 0.1;
  run.begin();
  SyntheticRun::Dynamic d;
  d.cycles = 5;
  d.branch_s = 4;
  d.anywhere = true;
  d.noise_F = 1e-18;
  d.capacitance_F = [&](double kPa, bool up) {
    const double rate_kPa_s = d.peak_N / SyntheticRun::area_m2() * 1e-3 / d.branch_s;
    const double then = std::max(0.0, kPa + (up ? -1 : 1) * rate_kPa_s * late_s);
    return 3.65e-12 + 680e-15 * (1 - std::exp(-then / 66));
  };
  run.play(d);
  run.end();
  auto out = analyse(run.db(), run.run());
  EXPECT_TRUE(out) << (out ? "" : out.error().what);
  return out ? std::move(*out) : RunAnalysis();
}

// The rate is constant and the curve bends. The part is the change from one standard uncertainty.
TEST(TurningPoint, TheErrorOfTheInstantOfABentCurveMovesItsSlopes) {
  const auto right = of_late_readings(0);
  const double u_s = right.ranges.at(0).instant_s;
  const auto late = of_late_readings(u_s);
  const char* name = "alignment of the clocks";
  for (const std::size_t k : {0U, 1U}) {
    const double moved =
        std::abs(late.ranges[k].sensitivity.value() - right.ranges[k].sensitivity.value());
    EXPECT_GT(moved, 0.005 * right.ranges[k].sensitivity.value());
    EXPECT_NEAR(size_of(right.uncertainties, right.ranges[k].uncertainty.quantity, name), moved,
                0.15 * moved);
  }
  const double moved = std::abs(late.force_sensitivity.value() - right.force_sensitivity.value());
  EXPECT_GT(moved, 0.005 * right.force_sensitivity.value());
  EXPECT_NEAR(size_of(right.uncertainties, "force sensitivity", name), moved, 0.15 * moved);
}

TEST(TurningPoint, TheErrorOfTheInstantOpensALoopWhereTheCurveIsSteepest) {
  const double u_s = of_late_readings(0).ranges.at(0).instant_s;
  const auto late = of_late_readings(u_s);
  const double gap = late.hysteresis.largest_gap.value();
  EXPECT_NEAR(size_of(late.uncertainties, "hysteresis", "alignment of the clocks"), gap,
              0.15 * gap);
  EXPECT_FALSE(late.hysteresis.resolved);
  EXPECT_LE(late.hysteresis.largest_gap.estimate->interval->front(), 0)
      << "it may be none: " << late.hysteresis.largest_gap.reason;
}

}  // namespace
}  // namespace lcrig
