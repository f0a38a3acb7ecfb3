// SPDX-License-Identifier: Apache-2.0
// How much the slope of a curve y(x) changes if all readings have the same error of their instant.
// The error moves each y by (dy/dx)(dx/dt). The slope therefore changes where the rate changes with
// x, and where the curve bends. Used for the uncertainty of slopes. Private to analysis/.
#pragma once

#include <vector>

namespace lcrig {

class MovedSlope {
 public:
  void begin_group();  // the points after it have an offset of their own: a repeat, a cycle
  void add(double x, double y, double rate);  // rate: dx/dt

  // Change of the slope per second of error. All groups share a parabola, if the points reveal one.
  double per_s() const;

 private:
  struct Point {
    double x = 0, y = 0, rate = 0;
  };
  std::vector<std::vector<Point>> groups_;
};

}  // namespace lcrig
