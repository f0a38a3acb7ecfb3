// SPDX-License-Identifier: Apache-2.0
// Intervals of results with a part that has one or two degrees of freedom, such as the slopes of
// two or three repeats. The tests integrate over the estimate of such a part to find how often the
// intervals hold.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "analysis/comparison.hpp"
#include "analysis/line_fit.hpp"
#include "analysis/metrics.hpp"

namespace lcrig {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Estimated over true variance, in the middles of `nodes` equal shares of its distribution.
std::vector<double> estimates_of_variance(int freedom, int nodes) {
  std::vector<double> out;
  for (int i = 0; i < nodes; ++i) {
    const double p = (i + 0.5) / nodes;
    const double z = freedom == 1 ? normal_quantile(0.5 + p / 2) : 0;
    out.push_back(freedom == 1 ? z * z : -std::log1p(-p));
  }
  return out;
}

double share_within(double half_width, double variance) {
  return std::erf(half_width / std::sqrt(2 * variance));
}

// How often the interval holds, in percent. The other part has standard deviation 1 and is known.
double holds_beside_known(int freedom, double deviation) {
  constexpr int kNodes = 200;
  double sum = 0;
  for (const double v : estimates_of_variance(freedom, kNodes)) {
    const Estimate e = estimate_of_parts(
        0, {{deviation * std::sqrt(v), static_cast<double>(freedom)}, {1, kInfinite}}, 0.95);
    sum += share_within((*e.interval)[1], deviation * deviation + 1);
  }
  return sum / kNodes * 100;
}

TEST(FewFreedom, IntervalHoldsHoweverLargeTheOtherPartIs) {
  for (const double deviation : {0.05, 0.2, 0.5, 1.0, 2.0, 4.0, 10.0, 50.0}) {
    EXPECT_NEAR(holds_beside_known(1, deviation), 95, 1.9) << deviation;
    EXPECT_NEAR(holds_beside_known(2, deviation), 95, 0.8) << deviation;
  }
}

RunAnalysis run_with(double freedom, double percent) {
  static std::int64_t number = 0;
  RunAnalysis a;
  a.run = ++number;
  a.ranges.resize(1);
  a.ranges[0].range = {0, 30};
  a.ranges[0].sensitivity.estimate = Estimate(100);
  Uncertainty u;
  u.quantity = "sensitivity 0-30 kPa";
  u.value = 100;
  UncertaintyPart scatter = part("scatter", percent, "made up");
  scatter.kind = UncertaintyKind::a;
  scatter.degrees_of_freedom = freedom;
  u.parts = {scatter, of(ErrorSource::cell, part("force", 1, "made up"))};
  a.uncertainties = {u};
  a.conditions.cell = "cell 1";
  a.conditions.setting.emplace();
  a.conditions.probe_diameter_m = 0.004;
  LoadState& load = a.ranges[0].sensitivity.load.emplace();
  load.pressures = {{10, 10, 0.5}, {20, 20, 0.5}};
  load.log10_s = 0;
  return a;
}

// How often the interval of the increase from one run to another holds, in percent. The scatter of
// the runs is `percent`.
double comparison_holds(int from_freedom, int to_freedom, double percent) {
  constexpr int kNodes = 25;
  constexpr double kSmall = 0.01;  // share of the value, so small that the logarithm is linear
  double sum = 0;
  for (const double v : estimates_of_variance(from_freedom, kNodes)) {
    const double of_from = kSmall * std::sqrt(v);
    const bool few = to_freedom < 3;
    for (const double w : few ? estimates_of_variance(to_freedom, kNodes) : std::vector{1.0}) {
      const RunAnalysis runs[] = {
          run_with(from_freedom, of_from),
          run_with(few ? to_freedom : kInfinite, kSmall * percent * std::sqrt(w))};
      const auto comparisons = compare(runs);
      const double half = (*comparisons.at(0).interval_percent)[1];
      sum += share_within(half, kSmall * kSmall * (1 + percent * percent)) / (few ? kNodes : 1);
    }
  }
  return sum / kNodes * 100;
}

// GUM G.4.1, as elsewhere: the 6.25 degrees of freedom of the two parts count as 6.
TEST(FewFreedom, IncreaseTruncatesItsDegreesOfFreedom) {
  const double few = 0.01, other = 0.005;
  const double variance = few * few + other * other;
  const double welch = 4 * variance * variance / std::pow(few, 4);
  ASSERT_NEAR(welch, 6.25, 1e-9);
  const RunAnalysis runs[] = {run_with(4, few), run_with(kInfinite, other)};
  const auto c = compare(runs);
  ASSERT_EQ(c.size(), 1U);
  const double half = coverage_factor(0.95, 6) * std::sqrt(variance) / 100;
  EXPECT_NEAR((*c[0].interval_percent)[1], (std::exp(half) - 1) * 100, 1e-9);
}

TEST(FewFreedom, IncreaseBetweenRunsHolds) {
  for (const double percent : {0.1, 0.3, 1.0, 3.0}) {
    EXPECT_GT(comparison_holds(1, 9, percent), 92.5) << percent;
    EXPECT_GT(comparison_holds(1, 1, percent), 92.5) << percent;
    EXPECT_LT(comparison_holds(1, 1, percent), 98.2) << percent;
    EXPECT_NEAR(comparison_holds(2, 2, percent), 95.5, 2) << percent;
  }
}

}  // namespace
}  // namespace lcrig
