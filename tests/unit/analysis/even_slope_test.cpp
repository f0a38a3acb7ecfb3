// SPDX-License-Identifier: Apache-2.0
// Compares slopes of branches with few readings with the slopes of known curves.
#include "analysis/even_slope.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace lcrig {
namespace {

// Points 8 apart from `first` up to 80, as a meter would take them that begins there.
std::vector<LinePoint> branch(double first, const std::function<double(double)>& curve) {
  std::vector<LinePoint> out;
  for (double x = first; x <= 80; x += 8) out.push_back({x, curve(x), 1});
  return out;
}

TEST(EvenSlopes, OfAParabolaAreThatOfTheMiddleWhereverTheReadingsFall) {
  const auto curve = [](double x) { return 3 * x - 0.01 * x * x; };
  EvenSlopes slopes(30, 80);
  for (const double first : {30.5, 33.0, 37.5}) ASSERT_TRUE(slopes.add(branch(first, curve)));
  for (const LineFit& l : slopes.lines()) EXPECT_NEAR(l.slope, 3 - 0.02 * 55, 1e-12);
}

TEST(EvenSlopes, OfACurveWithMoreThanABendDifferMuchLessThanItsLines) {
  const auto curve = [](double x) { return 5 * x + 160 * (1 - std::exp(-x / 40)); };
  EvenSlopes slopes(30, 80);
  double low = 1e9, high = 0, line_low = 1e9, line_high = 0;
  for (const double first : {30.5, 33.0, 35.5, 37.5}) {
    const auto points = branch(first, curve);
    ASSERT_TRUE(slopes.add(points));
    const double slope = fit_line(points)->slope;
    line_low = std::min(line_low, slope), line_high = std::max(line_high, slope);
  }
  for (const LineFit& l : slopes.lines())
    low = std::min(low, l.slope), high = std::max(high, l.slope);
  EXPECT_LT(high - low, (line_high - line_low) / 7);
}

TEST(EvenSlopes, TwoReadingsKeepTheirLine) {
  EvenSlopes slopes(0, 10);
  ASSERT_TRUE(slopes.add({{1, 1}, {2, 4}}));
  EXPECT_FALSE(slopes.add({{1, 1}}));
  ASSERT_EQ(slopes.lines().size(), 1U);
  EXPECT_DOUBLE_EQ(slopes.lines()[0].slope, 3);
  EXPECT_EQ(slopes.unit_variance_of_bend(), 0);
}

// Noise of variance 1 on a branch that covers the upper part of its range.
TEST(EvenSlopes, TheErrorOfTheBendIsInTheVariance) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  double squares = 0, expected = 0;
  constexpr int kRuns = 20'000;
  for (int i = 0; i < kRuns; ++i) {
    EvenSlopes slopes(20, 80);
    ASSERT_TRUE(slopes.add(branch(38, [&](double) { return normal(random); })));
    const LineFit line = slopes.lines()[0];
    squares += line.slope * line.slope / kRuns;
    expected = 1 / line.sxx + slopes.unit_variance_of_bend();
    ASSERT_GT(slopes.unit_variance_of_bend(), 0.1 / line.sxx);
  }
  EXPECT_NEAR(squares / expected, 1, 0.05);
}

}  // namespace
}  // namespace lcrig
