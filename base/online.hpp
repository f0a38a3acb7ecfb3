// SPDX-License-Identifier: Apache-2.0
// Estimators for the analysis, the budget and decisions during a run. A mean and a straight line,
// with their scatter, take values one by one and store none of them.
#pragma once

#include <cstdint>
#include <vector>

namespace lcrig {

// In the unit of the added values.
struct RunningMean {
  std::int64_t count = 0;
  double mean = 0;
  double sum_squares = 0;  // about the mean
  void add(double y);
  double variance() const { return sum_squares / static_cast<double>(count - 1); }  // of one value
  double mean_se() const;  // for independent values; needs two or more
};

// y = y_mean + slope (x - x_mean). Each point adds its squared error of prediction by the line so
// far, divided by a factor, to the sum of squared residuals. All terms are positive, so nothing
// cancels as it would in syy - sxy^2 / sxx.
class RunningLine {
 public:
  void add(double x, double y, double weight = 1);

  std::int64_t count() const { return count_; }
  double weights() const { return weights_; }
  double x_mean() const { return x_; }
  double y_mean() const { return y_; }
  double sxx() const { return sxx_; }  // weighted, about the means; 0: all x are equal
  double sxy() const { return sxy_; }
  double residual_ss() const { return residual_ss_; }
  double slope() const { return sxy_ / sxx_; }
  double slope_se() const;  // from the residuals; needs three or more points

 private:
  std::int64_t count_ = 0;
  double weights_ = 0, x_ = 0, y_ = 0;
  double sxx_ = 0, sxy_ = 0, residual_ss_ = 0;
};

// The median, which ignores a few spikes. Of an even count it is the larger of the two in the
// middle, so that it is one of the values; `median` of analysis/line_fit.hpp is the mean of the
// two. Reorders the values, of which there is at least one.
double upper_median(std::vector<double>& values);

}  // namespace lcrig
