// SPDX-License-Identifier: Apache-2.0
#include "analysis/replicates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace lcrig {

namespace {

constexpr int kSweeps = 200;
constexpr double kConverged = 1e-12;
// The offsets depend on the slope only as far as the pressures of a level differ: two passes do.
constexpr int kSlopes = 2;

struct Effect {
  double weight = 0, sum = 0, value = 0;
};

// One sweep of the fit: sets each effect to the weighted mean of what the other effects leave.
// Returns the largest change.
template <class Key, class KeyOf, class Rest>
double sweep(std::map<Key, Effect>& effects, const std::vector<RangePoint>& points, KeyOf key_of,
             Rest rest) {
  for (auto& [key, e] : effects) e.weight = e.sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Effect& e = effects[key_of(points[i])];
    e.weight += points[i].at.weight;
    e.sum += points[i].at.weight * rest(i);
  }
  double change = 0;
  for (auto& [key, e] : effects) {
    const double value = e.sum / e.weight;
    change = std::max(change, std::abs(value - e.value));
    e.value = value;
  }
  return change;
}

std::map<LevelKey, int> count_levels(const std::vector<RangePoint>& points) {
  std::map<LevelKey, int> out;
  for (const RangePoint& p : points) ++out[p.key];
  return out;
}

}  // namespace

AdditiveFit fit_additive(const std::vector<RangePoint>& all, double slope) {
  // A level that was measured once tells nothing about the differences between repeats.
  const auto counts = count_levels(all);
  std::vector<RangePoint> points;
  for (const RangePoint& p : all) {
    if (counts.at(p.key) >= 2) points.push_back(p);
  }
  AdditiveFit out;
  out.slope = slope;
  if (points.empty()) return out;
  std::map<LevelKey, Effect> levels;
  std::map<std::int32_t, Effect> repeats;
  out.x = points.front().at.x, out.y = points.front().at.y;
  double scale = 0;
  for (const RangePoint& p : points) scale = std::max(scale, std::abs(out.above_line(p)));
  for (int k = 0; k < kSweeps; ++k) {
    const double a = sweep(
        levels, points, [](const RangePoint& p) { return p.key; },
        [&](std::size_t i) { return out.above_line(points[i]) - repeats[points[i].repeat].value; });
    const double b = sweep(
        repeats, points, [](const RangePoint& p) { return p.repeat; },
        [&](std::size_t i) { return out.above_line(points[i]) - levels[points[i].key].value; });
    if (std::max(a, b) <= kConverged * scale) break;
  }
  for (const RangePoint& p : points) {
    const double r = out.above_line(p) - levels[p.key].value - repeats[p.repeat].value;
    out.residual_ss += p.at.weight * r * r;
  }
  out.freedom = static_cast<double>(points.size()) - static_cast<double>(levels.size()) -
                static_cast<double>(repeats.size()) + 1;
  double middle = 0;
  for (const auto& [repeat, e] : repeats) middle += e.value / static_cast<double>(repeats.size());
  for (const auto& [key, e] : levels) out.of_level[key] = e.value + middle;
  for (const auto& [repeat, e] : repeats) out.of_repeat[repeat] = e.value - middle;
  return out;
}

std::vector<RangePoint> without_offsets(std::vector<RangePoint> points) {
  for (int k = 0; k < kSlopes; ++k) {
    std::vector<LinePoint> line;
    line.reserve(points.size());
    for (const RangePoint& p : points) line.push_back(p.at);
    const auto fit = fit_line(line);
    if (!fit) break;
    const AdditiveFit additive = fit_additive(points, fit->slope);
    for (RangePoint& p : points) {
      if (const auto it = additive.of_repeat.find(p.repeat); it != additive.of_repeat.end()) {
        p.at.y -= it->second;
      }
    }
  }
  return points;
}

void weigh_as_planned(std::vector<RangePoint>& points) {
  struct Level {
    double repeats = 0, planned = 0, weight = 0;
  };
  std::map<LevelKey, Level> levels;
  for (const RangePoint& p : points) {
    Level& l = levels[p.key];
    l.repeats += 1;
    l.planned += static_cast<double>(p.planned);
    l.weight += p.at.weight;
  }
  double planned = 0, weight = 0;  // `planned`: readings of one repeat; `weight`: of all points
  for (const auto& [key, l] : levels) planned += l.planned / l.repeats, weight += l.weight;
  for (RangePoint& p : points) {
    const Level& l = levels.at(p.key);
    p.line_weight = p.at.weight * (l.planned / l.repeats * weight) / (l.weight * planned);
  }
}

std::optional<PureError> error_between_repeats(const std::vector<RangePoint>& points,
                                               double slope) {
  const AdditiveFit fit = fit_additive(points, slope);
  if (fit.freedom < 1) return std::nullopt;
  return PureError{fit.residual_ss / fit.freedom, fit.freedom,
                   fmt::format("scatter of {} levels between {} repeats", fit.of_level.size(),
                               fit.of_repeat.size())};
}

double reading_ss(const RangePoint& p, double slope) {
  return std::max(0.0, p.reading_ss - 2 * slope * p.cross_ss + slope * slope * p.pressure_ss);
}

std::optional<PureError> error_within_levels(const std::vector<RangePoint>& points, double slope) {
  double ss = 0, freedom = 0;
  for (const RangePoint& p : points) {
    ss += reading_ss(p, slope);
    freedom += static_cast<double>(std::max<std::int64_t>(p.readings - 1, 0));
  }
  if (freedom < 1) return std::nullopt;
  return PureError{ss / freedom, freedom, "scatter of the readings within the levels"};
}

RangePoint point_of(const MeasuredLevel& l, double fF) {
  RangePoint p;
  p.at = {l.pressure_kPa, fF, static_cast<double>(l.readings)};
  p.key = key_of(l);
  p.repeat = l.repeat;
  p.level = l.level;
  p.t_s = l.t_s;
  p.readings = l.readings;
  p.planned = l.readings + l.missing;
  p.line_weight = p.at.weight;
  const double s = l.scatter_fF.value_or(0);
  p.reading_ss = (l.readings - 1) * s * s;
  p.trend_ss = l.trend_ss_fF2;
  p.pressure_ss = (l.readings - 1) * l.pressure_scatter_kPa * l.pressure_scatter_kPa;
  p.cross_ss = (l.readings - 1) * l.covariance_fF_kPa;
  return p;
}

RangePoint point_of(const LevelResult& l) {
  return point_of(l, l.capacitance_pF * 1e3);
}

std::vector<RangePoint> all_points(const LevelResults& levels) {
  std::vector<RangePoint> points;
  for (const LevelResult& l : levels.levels) {
    if (l.direction == levels.line_direction) points.push_back(point_of(l));
  }
  return points;
}

}  // namespace lcrig
