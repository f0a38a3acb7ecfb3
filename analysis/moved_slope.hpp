// SPDX-License-Identifier: Apache-2.0
// What one error of the instant, alike in all readings, does to the slope of a curve y(x): it moves
// each y by (dy/dx)(dx/dt), so the slope moves where the rate changes with x, and where the curve
// bends.
#pragma once

#include <vector>

namespace lcrig {

class MovedSlope {
 public:
  void begin_group();  // the next points have an offset of their own: a repeat, a cycle
  void add(double x, double y, double rate);  // rate: dx/dt

  // Change of the slope for each second of error. All groups share a parabola, if they tell one.
  double per_s() const;

 private:
  struct Point {
    double x = 0, y = 0, rate = 0;
  };
  std::vector<std::vector<Point>> groups_;
};

}  // namespace lcrig
