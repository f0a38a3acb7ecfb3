// SPDX-License-Identifier: Apache-2.0
#include "base/online.hpp"

#include <algorithm>
#include <cmath>

namespace lcrig {

void RunningMean::add(double y) {
  ++count;
  const double d = y - mean;
  mean += d / static_cast<double>(count);
  sum_squares += d * (y - mean);
}

double RunningMean::mean_se() const {
  return std::sqrt(variance() / static_cast<double>(count));
}

void RunningLine::add(double x, double y, double weight) {
  ++count_;
  const double dx = x - x_, dy = y - y_;
  const double weights = weights_ + weight;
  if (weights_ > 0) {
    const double shorter = 1 / weight + 1 / weights_;
    if (sxx_ > 0) {
      const double error = dy - sxy_ / sxx_ * dx;
      residual_ss_ += error * error / (shorter + dx * dx / sxx_);
    } else if (dx == 0) {  // else: the second different x, where the line passes through both
                           // points
      residual_ss_ += dy * dy / shorter;
    }
    sxx_ += dx * dx / shorter;
    sxy_ += dx * dy / shorter;
  }
  x_ += weight / weights * dx;
  y_ += weight / weights * dy;
  weights_ = weights;
}

double RunningLine::slope_se() const {
  return std::sqrt(residual_ss_ / static_cast<double>(count_ - 2) / sxx_);
}

double upper_median(std::vector<double>& values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace lcrig
