// SPDX-License-Identifier: Apache-2.0
// Fits straight lines through measured points, and judges them by their scatter. All sums are taken
// about the weighted mean, so that an offset of x or y costs no digits. The whole analysis uses it,
// and the budget.
#pragma once

#include <span>
#include <vector>

#include "base/result.hpp"

namespace lcrig {

struct LinePoint {
  double x = 0, y = 0;
  double weight = 1;  // > 0; relative
};

// y = y_mean + slope (x - x_mean). With variance s2 of a point of weight 1: var(slope) = s2/sxx,
// var(y_mean) = s2/sum_weights, and the two are not correlated.
struct LineFit {
  double slope = 0;
  double x_mean = 0, y_mean = 0;
  double sum_weights = 0;
  double sxx = 0, sxy = 0, syy = 0;  // weighted, about the means
  double residual_ss = 0;  // weighted
  double r_squared = 0;  // 1 when all y are alike
  int points = 0;
  int distinct_x = 0;

  double at(double x) const { return y_mean + slope * (x - x_mean); }
  double slope_se(double variance) const;  // from the variance of a point of weight 1
  double slope_se() const;  // from the residuals of three or more points
};
// Errors (invalid_request): fewer than two points; all x alike; weights that are not positive;
// values that are not finite.
Result<LineFit> fit_line(std::span<const LinePoint> points);

// Huber's M-estimate of location (k = 1.345, 95 % efficient); values not empty.
double huber_location(const std::vector<double>& values);

// Student's t: the quantile at `probability` (0.975 for a 95 % interval). Infinite degrees of
// freedom: the normal law. degrees_of_freedom > 0.
double student_t_quantile(double probability, double degrees_of_freedom);
// Half the width of the central interval, in standard errors.
double coverage_factor(double confidence, double degrees_of_freedom);
// Its inverse, by halving: 1 to a million.
double freedom_of_factor(double factor, double confidence);
// Of a sum of squares of `degrees_of_freedom` normal numbers.
double chi_square_quantile(double probability, double degrees_of_freedom);
// P(F > f); f_tail(-..., ...) is 1.
double f_tail(double f, double dof1, double dof2);
double normal_quantile(double probability);

double median(std::vector<double> values);  // not empty
// 1.4826 times the median absolute deviation from the median; 0 for fewer than two values.
double robust_sigma(const std::vector<double>& values);

// Wald and Wolfowitz on the signs of residuals in the order of x: a small p says that a straight
// line is not the shape of the data (few runs) or that they alternate (many).
struct RunsTest {
  int runs = 0, above = 0, below = 0;
  double p = 1;  // two-sided; 1 when there are too few points to tell
};
RunsTest runs_test(std::span<const double> residuals);

// Two straight lines, one below and one above a limit between two points; chosen for the least sum
// of squares. At least `least` different x on either side. Takes n log n for n points.
struct TwoRegions {
  double last_low_x = 0, first_high_x = 0;  // of the points on either side
  LineFit low, high;
  double p_one_line = 1;  // F test (Chow): that one line would do as well
};
Result<TwoRegions> find_two_regions(std::span<const LinePoint> points, int least = 3);

}  // namespace lcrig
