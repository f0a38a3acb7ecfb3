// SPDX-License-Identifier: Apache-2.0
// The slope of a bent curve from branches with few readings. Where on a branch they fall is chance,
// and moves the slope of the line through them (by 4 % for six readings of paper-1 in 35-100 kPa).
// All branches share a bend; with it each slope becomes that of readings evenly over the range.
// Used by the analysis and, on planned readings, by the budget.
#pragma once

#include <vector>

#include "analysis/line_fit.hpp"

namespace lcrig {

class EvenSlopes {
 public:
  EvenSlopes(double from, double to) : middle_((from + to) / 2), half_((to - from) / 2) {}

  // False: there is no line through these points, and they are left out.
  bool add(const std::vector<LinePoint>& points);
  // The lines of all branches, in the order of `add`, with the slope over the whole range.
  std::vector<LineFit> lines() const;
  // Variance that the error of the bend adds to the mean slope, weighted with the spread of the
  // branches, for unit variance of a reading.
  double unit_variance_of_bend() const;

 private:
  struct Branch {
    LineFit line;
    double tilt = 0;  // of a unit bend, along the points
  };
  double bend() const;

  double middle_, half_;
  std::vector<Branch> branches_;
  double squares_ = 0, product_ = 0, freedom_ = 0;  // of the bend beside a line in each branch
};

}  // namespace lcrig
