// SPDX-License-Identifier: Apache-2.0
// Estimators that are fed value by value and keep none of them: a mean and a straight line with
// their scatter. The analysis and the budget use them, and what a run decides while it goes on.
#pragma once

#include <cstdint>

namespace lcrig {

// In the unit of the caller.
struct RunningMean {
  std::int64_t count = 0;
  double mean = 0;
  double sum_squares = 0;  // about the mean
  void add(double y);
  double variance() const { return sum_squares / static_cast<double>(count - 1); }  // of a value
  double mean_se() const;  // when the values do not depend on each other; two or more
};

// y = y_mean + slope (x - x_mean). What a point adds to the sum of squared residuals is its error
// of prediction by the line so far, squared and shortened: only positive terms, so that nothing
// cancels, as it would in syy - sxy^2 / sxx.
class RunningLine {
 public:
  void add(double x, double y, double weight = 1);

  std::int64_t count() const { return count_; }
  double weights() const { return weights_; }
  double x_mean() const { return x_; }
  double y_mean() const { return y_; }
  double sxx() const { return sxx_; }  // weighted, about the means; 0: all x are alike
  double sxy() const { return sxy_; }
  double residual_ss() const { return residual_ss_; }
  double slope() const { return sxy_ / sxx_; }
  double slope_se() const;  // from the residuals of three or more points

 private:
  std::int64_t count_ = 0;
  double weights_ = 0, x_ = 0, y_ = 0;
  double sxx_ = 0, sxy_ = 0, residual_ss_ = 0;
};

}  // namespace lcrig
