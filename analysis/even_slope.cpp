// SPDX-License-Identifier: Apache-2.0
#include "analysis/even_slope.hpp"

#include <cmath>

namespace lcrig {

bool EvenSlopes::add(const std::vector<LinePoint>& points) {
  const auto line = fit_line(points);
  if (!line) return false;
  branches_.push_back({*line, 0});
  if (!(half_ > 0)) return true;
  std::vector<LinePoint> bent = points;  // y becomes a unit bend: 1 at both ends of the range
  for (LinePoint& p : bent) p.y = std::pow((p.x - middle_) / half_, 2);
  const auto fit = fit_line(bent);
  if (!fit) return true;
  branches_.back().tilt = fit->slope;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double beside = bent[i].y - fit->at(points[i].x);
    squares_ += points[i].weight * beside * beside;
    product_ += points[i].weight * beside * (points[i].y - line->at(points[i].x));
  }
  freedom_ += line->points - 2;
  return true;
}

// 0 (no bend) when too few degrees of freedom remain to judge it, or when the points reveal none.
double EvenSlopes::bend() const {
  return freedom_ >= 2 && squares_ > 1e-9 ? product_ / squares_ : 0;
}

std::vector<LineFit> EvenSlopes::lines() const {
  std::vector<LineFit> out;
  out.reserve(branches_.size());
  for (const Branch& b : branches_) {
    out.push_back(b.line);
    out.back().slope -= bend() * b.tilt;
  }
  return out;
}

double EvenSlopes::unit_variance_of_bend() const {
  if (freedom_ < 2 || squares_ <= 1e-9) return 0;
  double tilt = 0, sxx = 0;
  for (const Branch& b : branches_) tilt += b.line.sxx * b.tilt, sxx += b.line.sxx;
  return sxx > 0 ? tilt / sxx * tilt / sxx / squares_ : 0;
}

}  // namespace lcrig
