// SPDX-License-Identifier: Apache-2.0
// Corrects the slope of a bent curve from branches with few readings. Where on a branch the
// readings fall is chance, and it moves the slope of a straight line through them (by 4 % for six
// readings of paper-1 in 35-100 kPa). All branches are fitted with one common bend. With it each
// slope becomes the slope of readings spread evenly over the range. The analysis uses it on
// readings, the budget on planned readings.
#pragma once

#include <vector>

#include "analysis/line_fit.hpp"

namespace lcrig {

class EvenSlopes {
 public:
  EvenSlopes(double from, double to) : middle_((from + to) / 2), half_((to - from) / 2) {}

  // False: no line goes through these points, and they are left out.
  bool add(const std::vector<LinePoint>& points);
  // The lines of all branches, in the order of `add`, with slopes corrected to the whole range.
  std::vector<LineFit> lines() const;
  // Variance that the error of the bend adds to the mean slope, if a reading has variance 1. The
  // mean is weighted with the spread of the branches.
  double unit_variance_of_bend() const;

 private:
  struct Branch {
    LineFit line;
    double tilt = 0;  // slope that a unit bend has along these points
  };
  double bend() const;

  double middle_, half_;
  std::vector<Branch> branches_;
  double squares_ = 0, product_ = 0, freedom_ = 0;  // of the bend, beside a line in each branch
};

}  // namespace lcrig
