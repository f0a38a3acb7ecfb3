// SPDX-License-Identifier: Apache-2.0
// Fits straight lines through measured points and judges them by their scatter. All sums are taken
// about the weighted mean, so that an offset of x or y costs no digits. All passes of the analysis
// use it, and the budget.
#pragma once

#include <span>
#include <vector>

#include "base/result.hpp"

namespace lcrig {

struct LinePoint {
  double x = 0, y = 0;
  double weight = 1;  // relative; must be positive
};

// The fit y = y_mean + slope (x - x_mean). If a point of weight 1 has variance s2, then var(slope)
// = s2/sxx and var(y_mean) = s2/sum_weights, and the two are not correlated.
struct LineFit {
  double slope = 0;
  double x_mean = 0, y_mean = 0;
  double sum_weights = 0;
  double sxx = 0, sxy = 0, syy = 0;  // weighted sums about the means
  double residual_ss = 0;  // weighted
  double r_squared = 0;  // 1 when all y are equal
  int points = 0;
  int distinct_x = 0;

  double at(double x) const { return y_mean + slope * (x - x_mean); }
  double slope_se(double variance) const;  // `variance`: of a point of weight 1
  double slope_se() const;  // with the variance of the residuals; needs three points
};
// Errors (invalid_request): fewer than two points; all x equal; weights that are not positive;
// values that are not finite.
Result<LineFit> fit_line(std::span<const LinePoint> points);

// Huber's M-estimate of location (k = 1.345, 95 % efficient). `values` must not be empty.
double huber_location(const std::vector<double>& values);

// Quantile of Student's t at `probability` (0.975 for a 95 % interval). Infinite degrees of freedom
// give the normal distribution. Precondition: degrees_of_freedom > 0.
double student_t_quantile(double probability, double degrees_of_freedom);
// Half the width of the central interval of Student's t, in standard errors.
double coverage_factor(double confidence, double degrees_of_freedom);
// Inverse of coverage_factor: the degrees of freedom, by bisection between 1 and a million.
double freedom_of_factor(double factor, double confidence);
// Quantile of a sum of squares of `degrees_of_freedom` standard normal numbers.
double chi_square_quantile(double probability, double degrees_of_freedom);
// P(F > f). For a negative f it is 1.
double f_tail(double f, double dof1, double dof2);
double normal_quantile(double probability);

// The mean of the two in the middle when the count is even; `upper_median` of base/online.hpp is
// one of the values. Precondition: not empty.
double median(std::vector<double> values);
// 1.4826 times the median absolute deviation from the median; 0 for fewer than two values.
double robust_sigma(const std::vector<double>& values);

// Wald and Wolfowitz's test on the signs of residuals in the order of x. A small p means that the
// data do not follow a straight line (few runs) or that they alternate (many).
struct RunsTest {
  int runs = 0, above = 0, below = 0;
  double p = 1;  // two-sided; 1 when there are too few points
};
RunsTest runs_test(std::span<const double> residuals);

// Two straight lines, one below and one above a limit that lies between two points and gives the
// least sum of squares. Each side has at least `least` different x. Takes n log n for n points.
struct TwoRegions {
  double last_low_x = 0, first_high_x = 0;  // of the points next to the limit
  LineFit low, high;
  double p_one_line = 1;  // F test (Chow) of the hypothesis that one line is enough
};
Result<TwoRegions> find_two_regions(std::span<const LinePoint> points, int least = 3);

}  // namespace lcrig
