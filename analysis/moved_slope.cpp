// SPDX-License-Identifier: Apache-2.0
#include "analysis/moved_slope.hpp"

#include "base/online.hpp"

namespace lcrig {

namespace {

// Sums of products about the means of each group.
struct Sums {
  double xx = 0, xq = 0, qq = 0, xy = 0, qy = 0, xp = 0, freedom = 0;

  template <class Group, class Square, class Moved>
  void add(const Group& group, const Square& q, const Moved& p) {
    const auto n = static_cast<double>(group.size());
    double x = 0, square = 0, y = 0, moved = 0;
    for (const auto& g : group) {
      x += g.x / n, square += q(g) / n, y += g.y / n, moved += p(g) / n;
    }
    for (const auto& g : group) {
      const double dx = g.x - x, dq = q(g) - square;
      xx += dx * dx;
      xq += dx * dq;
      qq += dq * dq;
      xy += dx * (g.y - y);
      qy += dq * (g.y - y);
      xp += dx * (p(g) - moved);
    }
    freedom += n - 1;
  }
};

}  // namespace

void MovedSlope::begin_group() {
  groups_.emplace_back();
}

void MovedSlope::add(double x, double y, double rate) {
  if (groups_.empty()) begin_group();
  groups_.back().push_back({x, y, rate});
}

double MovedSlope::per_s() const {
  RunningMean x;
  for (const auto& group : groups_) {
    for (const Point& g : group) x.add(g.x);
  }
  const auto q = [&x](const Point& g) { return (g.x - x.mean) * (g.x - x.mean); };
  Sums curve, moved;
  for (const auto& group : groups_) curve.add(group, q, [](const Point&) { return 0.0; });
  if (!(curve.xx > 0)) return 0;
  double slope = curve.xy / curve.xx, bend = 0;
  const double determinant = curve.xx * curve.qq - curve.xq * curve.xq;
  if (curve.freedom >= 3 && determinant > 1e-6 * curve.xx * curve.qq) {
    slope = (curve.xy * curve.qq - curve.qy * curve.xq) / determinant;
    bend = (curve.qy * curve.xx - curve.xy * curve.xq) / determinant;
  }
  for (const auto& group : groups_) {
    moved.add(group, q,
              [&](const Point& g) { return (slope + 2 * bend * (g.x - x.mean)) * g.rate; });
  }
  return moved.xp / curve.xx;
}

}  // namespace lcrig
