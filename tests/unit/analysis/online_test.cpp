// SPDX-License-Identifier: Apache-2.0
// Estimators that are fed value by value must agree with a fit to all values at once.
#include "base/online.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "analysis/line_fit.hpp"

namespace lcrig {
namespace {

constexpr double kOffset = 1e6;  // a large mean costs no digits

TEST(RunningMean, IsTheMeanAndItsError) {
  RunningMean m;
  for (const double y : {1.0, 2.0, 4.0, 5.0}) m.add(kOffset + y);
  EXPECT_DOUBLE_EQ(m.mean, kOffset + 3);
  EXPECT_NEAR(m.variance(), 10.0 / 3, 1e-9);
  EXPECT_NEAR(m.mean_se(), std::sqrt(10.0 / 3 / 4), 1e-9);
}

TEST(RunningLine, IsTheLineThroughAllPoints) {
  std::vector<LinePoint> points;
  RunningLine line;
  for (int i = 0; i < 20; ++i) {
    const LinePoint p{kOffset + i, kOffset + 2.0 * i + (i % 3 - 1) * 0.1, 1.0 + i % 4};
    points.push_back(p);
    line.add(p.x, p.y, p.weight);
  }
  const auto fit = fit_line(points);
  ASSERT_TRUE(fit);
  EXPECT_EQ(line.count(), 20);
  EXPECT_NEAR(line.slope(), fit->slope, 1e-9);
  EXPECT_NEAR(line.sxx(), fit->sxx, 1e-6);
  EXPECT_NEAR(line.x_mean(), fit->x_mean, 1e-6);
  EXPECT_NEAR(line.y_mean(), fit->y_mean, 1e-6);
  EXPECT_NEAR(line.residual_ss(), fit->residual_ss, 1e-6);
  EXPECT_NEAR(line.slope_se(), fit->slope_se(fit->residual_ss / 18), 1e-9);
}

TEST(RunningLine, OfPointsThatLieAtOnePlaceHasNoSlope) {
  RunningLine line;
  line.add(1, 2);
  line.add(1, 4);
  EXPECT_EQ(line.sxx(), 0);
  EXPECT_DOUBLE_EQ(line.residual_ss(), 2);
}

}  // namespace
}  // namespace lcrig
