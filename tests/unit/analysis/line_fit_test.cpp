// SPDX-License-Identifier: Apache-2.0
#include "analysis/line_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/uncertainty.hpp"

namespace lcrig {
namespace {

// The reference regression: y = 3.65 + 8.9e-3 (10 i) - 1e-7 (10 i)^2, whose slope is 8.89e-3.
std::vector<LinePoint> reference(double offset) {
  std::vector<LinePoint> points;
  for (int i = 0; i <= 10; ++i) {
    const double x = 10.0 * i;
    points.push_back({offset + x, 3.65 + 8.9e-3 * x - 1e-7 * x * x, 1});
  }
  return points;
}

TEST(FitLine, KeepsItsDigitsWithAnOffsetOfOneHundredMillion) {
  for (const double offset : {0.0, 1e3, 1e6, 1e8}) {
    const auto fit = fit_line(reference(offset));
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->slope / 8.89e-3, 1, 1e-12) << "offset " << offset;
  }
}

TEST(FitLine, ResolvesOneFemtofaradOnFortyPicofarad) {
  std::vector<LinePoint> points;  // fF; the meter's own last digit would be 0.1 fF
  for (int i = 0; i <= 10; ++i) points.push_back({10.0 * i, 40000 + 0.01 * 10 * i, 1});
  EXPECT_NEAR(fit_line(points)->slope, 0.01, 1e-11);
}

TEST(FitLine, DoesNotDependOnTheOrder) {
  auto points = reference(0);
  const double forward = fit_line(points)->slope;
  std::reverse(points.begin(), points.end());
  EXPECT_NEAR(fit_line(points)->slope, forward, 1e-16);
}

TEST(FitLine, RefusesPointsAtOnePressureAndBadNumbers) {
  const std::vector<LinePoint> same{{5, 1, 1}, {5, 2, 1}, {5, 3, 1}};
  EXPECT_NE(fit_line(same).error().what.find("x = 5"), std::string::npos);
  const std::vector<LinePoint> one{{5, 1, 1}};
  EXPECT_FALSE(fit_line(one));
  const std::vector<LinePoint> nan{{5, 1, 1}, {6, std::nan(""), 1}};
  EXPECT_FALSE(fit_line(nan));
  const std::vector<LinePoint> weightless{{5, 1, 1}, {6, 1, 0}};
  EXPECT_FALSE(fit_line(weightless));
}

TEST(FitLine, WeightsCountAsRepeatedPoints) {
  const std::vector<LinePoint> weighted{{0, 1, 3}, {1, 2, 1}, {2, 5, 2}};
  const std::vector<LinePoint> repeated{{0, 1, 1}, {0, 1, 1}, {0, 1, 1},
                                        {1, 2, 1}, {2, 5, 1}, {2, 5, 1}};
  const auto a = fit_line(weighted), b = fit_line(repeated);
  EXPECT_NEAR(a->slope, b->slope, 1e-14);
  EXPECT_NEAR(a->slope_se(2), b->slope_se(2), 1e-14);
  EXPECT_NEAR(a->residual_ss, b->residual_ss, 1e-13);
}

TEST(HuberLocation, IsHardlyMovedByAValueThatIsFarOff) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(2, 0.1);
  std::vector<double> values;
  for (int i = 0; i < 40; ++i) values.push_back(noise(random));
  values[39] += 50;
  EXPECT_NEAR(huber_location(values), 2, 0.05);
}

TEST(Quantiles, AreThoseOfTheTables) {
  EXPECT_NEAR(student_t_quantile(0.975, 1), 12.7062, 1e-4);
  EXPECT_NEAR(student_t_quantile(0.975, 10), 2.22814, 1e-5);
  EXPECT_NEAR(coverage_factor(0.95, std::numeric_limits<double>::infinity()), 1.959964, 1e-6);
  EXPECT_NEAR(f_tail(4.96, 1, 10), 0.05, 1e-4);
}

TEST(RunsTest, SeesABendAndLeavesScatterAlone) {
  const std::vector<double> bend{-1, -1, -1, -1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1};
  EXPECT_LT(runs_test(bend).p, 0.05);
  const std::vector<double> scatter{1, -1, -1, 1, 1, -1, 1, -1, -1, 1, -1, 1};
  EXPECT_GT(runs_test(scatter).p, 0.2);
  const std::vector<double> few{1, -1, 1};
  EXPECT_EQ(runs_test(few).p, 1);
}

TEST(TwoRegions, FindsTheKneeAndRefusesTooFewPoints) {
  std::vector<LinePoint> points;
  for (int i = 1; i <= 10; ++i) {
    points.push_back({10.0 * i, i <= 4 ? 20.0 * i : 80 + 5.0 * (i - 4), 1});
    points.back().y += i % 2 == 0 ? 0.1 : -0.1;
  }
  const auto found = find_two_regions(points);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->last_low_x, 35, 5.1);
  EXPECT_NEAR(found->low.slope, 2, 0.05);
  EXPECT_NEAR(found->high.slope, 0.5, 0.05);
  EXPECT_LT(found->p_one_line, 1e-6);
  points.resize(5);
  EXPECT_FALSE(find_two_regions(points));
}

// Tries every limit in turn and fits both lines anew: slow, but simple enough to be right.
struct Tried {
  std::size_t cut = 0;
  double ss = 0;
};
Tried try_every_limit(std::vector<LinePoint> points, int least) {
  std::sort(points.begin(), points.end(),
            [](const LinePoint& a, const LinePoint& b) { return a.x < b.x; });
  const std::span<const LinePoint> all(points);
  Tried best;
  for (std::size_t cut = 1; cut < all.size(); ++cut) {
    if (all[cut].x == all[cut - 1].x) continue;
    const auto low = fit_line(all.first(cut)), high = fit_line(all.subspan(cut));
    if (!low || !high || low->distinct_x < least || high->distinct_x < least) continue;
    const double ss = low->residual_ss + high->residual_ss;
    if (best.cut == 0 || ss < best.ss) best = {cut, ss};
  }
  return best;
}

struct Knee {
  double x0 = 0, y0 = 0;  // offsets
  double low = 20, high = 5, noise = 0.5;
  int points = 200, repeats = 1;
};
std::vector<LinePoint> with_knee(const Knee& k, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, k.noise);
  std::vector<LinePoint> points;
  for (int i = 0; i < k.points; ++i) {
    const double x = 100.0 * i / k.points;
    const double y = x < 33 ? k.low * x : 33 * k.low + k.high * (x - 33);
    for (int r = 0; r < k.repeats; ++r) {
      points.push_back({k.x0 + x, k.y0 + y + noise(random), 1.0 + (i + r) % 4});
    }
  }
  std::shuffle(points.begin(), points.end(), random);
  return points;
}

TEST(TwoRegions, AgreeWithTryingEveryLimit) {
  const std::vector<Knee> knees{{},
                                {1e8, 0, 20, 5, 0.5, 200, 1},  // an offset of 1e8
                                {1e8, 4e4, 0.01, 0.0025, 1e-4, 200, 1},  // 1 fF on 40 pF
                                {0, 4e4, 0.01, 0.0025, 1e-9, 200, 1},  // next to no scatter
                                {-1e8, -4e4, 0.01, 0.011, 0.3, 150, 2},  // no knee to see
                                {0, 0, 20, 5, 5, 20, 12},  // many at one x
                                {0, 0, 20, 5, 1, 6, 3},  // as few as there may be
                                {0, 0, 1e-15, 1e-16, 1e-17, 100, 1},  // in farads
                                {0, 0, 0, 0, 1, 100, 1}};
  for (std::size_t k = 0; k < knees.size(); ++k) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const auto points = with_knee(knees[k], seed);
      const auto tried = try_every_limit(points, 3);
      const auto found = find_two_regions(points);
      ASSERT_TRUE(found) << found.error().what;
      EXPECT_EQ(static_cast<std::size_t>(found->low.points), tried.cut) << k << ", seed " << seed;
      EXPECT_NEAR((found->low.residual_ss + found->high.residual_ss) / tried.ss, 1, 1e-9)
          << k << ", seed " << seed;
    }
  }
}

// Trying every limit would take hours.
TEST(TwoRegions, AreFoundAmongTwoHundredThousandPoints) {
  const auto found = find_two_regions(with_knee({1e8, 4e4, 20, 5, 0.5, 200'000, 1}, 1));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->last_low_x, 1e8 + 33, 0.05);
  EXPECT_NEAR(found->low.slope, 20, 5e-4);
  EXPECT_NEAR(found->high.slope, 5, 5e-4);
}

TEST(Uncertainty, CombinesWithWelchAndSatterthwaite) {
  Uncertainty b;
  UncertaintyPart a;
  a.standard_uncertainty = 3;
  a.kind = UncertaintyKind::a;
  a.degrees_of_freedom = 9;
  UncertaintyPart s;
  s.standard_uncertainty = 4;
  b.parts = {a, s};
  combine(b);
  EXPECT_NEAR(b.combined, 5, 1e-12);
  EXPECT_EQ(b.effective_degrees_of_freedom, 69) << "625/9, truncated (GUM G.4.1)";
  EXPECT_NEAR(b.expanded, 5 * student_t_quantile(0.975, 69), 1e-9);
  b.least = 20;
  combine(b);
  EXPECT_EQ(b.expanded, 20) << "never below the half-width of the scatter alone";
  EXPECT_EQ(b.dominating()->standard_uncertainty, 4);
  EXPECT_NEAR(rectangular(1), 0.57735, 1e-5);
}

}  // namespace
}  // namespace lcrig
