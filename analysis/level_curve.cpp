// SPDX-License-Identifier: Apache-2.0
// The curve over the levels of all repeats: how straight it is, and how well it repeats.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "analysis/replicates.hpp"

namespace lcrig {

namespace {

struct Point {
  RunningMean capacitance;  // pF, of the means of the levels
  double weighted_pF = 0, weighted_kPa = 0;
  double variance_of_sum = 0;  // of weighted_pF, from the scatter of the readings
  std::int64_t readings = 0;
  double low_pF = 0, high_pF = 0;
  std::map<std::int32_t, double> of_repeat;  // mean of each repeat, pF
};

std::map<LevelKey, Point> group(const LevelResults& levels) {
  std::map<LevelKey, Point> points;
  for (const LevelResult& l : levels.levels) {
    Point& p = points[key_of(l)];
    if (p.readings == 0) p.low_pF = p.high_pF = l.capacitance_pF;
    p.low_pF = std::min(p.low_pF, l.capacitance_pF);
    p.high_pF = std::max(p.high_pF, l.capacitance_pF);
    p.capacitance.add(l.capacitance_pF);
    p.of_repeat[l.repeat] = l.capacitance_pF;
    p.weighted_pF += l.readings * l.capacitance_pF;
    p.weighted_kPa += l.readings * l.pressure_kPa;
    const double se = l.standard_error_fF.value_or(0) * 1e-3 * l.readings;
    p.variance_of_sum += se * se;
    p.readings += l.readings;
  }
  return points;
}

// Error from the scatter between repeats, if there are several; a moving C0 is part of it.
std::optional<double> error_of(const Point& p) {
  const auto repeats = static_cast<double>(p.capacitance.count);
  if (repeats >= 2) return std::sqrt(p.capacitance.variance() / repeats) * 1e3;
  if (p.variance_of_sum > 0) {
    return std::sqrt(p.variance_of_sum) / static_cast<double>(p.readings) * 1e3;
  }
  return std::nullopt;
}

std::vector<CurvePoint> build_curve(const std::map<LevelKey, Point>& points, const Metric& c0) {
  std::vector<CurvePoint> out;
  for (const auto& [key, p] : points) {
    CurvePoint c;
    c.direction = key.direction;
    const auto n = static_cast<double>(p.readings);
    c.pressure_kPa = p.weighted_kPa / n;
    c.capacitance_pF = p.weighted_pF / n;
    if (c0) c.delta_C_fF = (c.capacitance_pF - c0.value()) * 1e3;
    c.standard_error_fF = error_of(p);
    c.repeats = static_cast<std::int32_t>(p.capacitance.count);
    c.readings = p.readings;
    out.push_back(c);
  }
  std::sort(out.begin(), out.end(), [](const CurvePoint& a, const CurvePoint& b) {
    return a.direction != b.direction ? a.direction < b.direction : a.pressure_kPa < b.pressure_kPa;
  });
  return out;
}

std::vector<LinePoint> line_points(const CurveResult& out, Direction direction) {
  std::vector<LinePoint> points;
  for (const CurvePoint& c : out.curve) {
    if (c.direction == direction) {
      points.push_back({c.pressure_kPa, c.capacitance_pF * 1e3, 1});
    }
  }
  return points;
}

double span_of_curve_fF(const CurveResult& out) {
  double low = 0, high = 0;
  bool first = true;
  for (const CurvePoint& c : out.curve) {
    low = first ? c.capacitance_pF : std::min(low, c.capacitance_pF);
    high = first ? c.capacitance_pF : std::max(high, c.capacitance_pF);
    first = false;
  }
  return (high - low) * 1e3;
}

double mean_square_error(const CurveResult& out) {
  double sum = 0;
  int n = 0;
  for (const CurvePoint& c : out.curve) {
    if (!c.standard_error_fF) continue;
    sum += *c.standard_error_fF * *c.standard_error_fF;
    ++n;
  }
  return n > 0 ? sum / n : 0;
}

double largest_deviation(const std::vector<LinePoint>& points, double slope, double x, double y) {
  double largest = 0;
  for (const LinePoint& p : points) {
    largest = std::max(largest, std::abs(p.y - (y + slope * (p.x - x))));
  }
  return largest;
}

void calc_linearity(Direction direction, CurveResult& out) {
  out.linearity = metric("linearity", "%",
                         "largest deviation of the curve from its best straight line over all "
                         "levels, over the span of the curve");
  out.linearity_terminal = metric("linearity_terminal", "%",
                                  "the same against the line through the first and last level");
  const auto points = line_points(out, direction);
  const auto line = fit_line(points);
  const double span = span_of_curve_fF(out);
  if (!line || line->distinct_x < 3 || span <= 0) {
    out.linearity.reason = out.linearity_terminal.reason = "it takes three different pressures";
    return;
  }
  const double error = std::sqrt(mean_square_error(out)) / span * 100;
  const auto set = [&](Metric& m, double deviation) {
    m.estimate = Estimate(deviation / span * 100);
    if (error > 0) m.estimate->standard_error = error;
    for (const CurvePoint& c : out.curve) m.rows += c.readings;
  };
  set(out.linearity, largest_deviation(points, line->slope, line->x_mean, line->y_mean));
  const LinePoint &a = points.front(), &b = points.back();
  set(out.linearity_terminal, largest_deviation(points, (b.y - a.y) / (b.x - a.x), a.x, a.y));
  if (mean_square_error(out) > 0 && out.linearity.value() < 2 * error) {
    out.linearity.reason = "no larger than the scatter of the levels makes it";
  }
}

// Differences between repeats move all levels of a repeat alike. All levels together therefore tell
// the scatter between repeats hardly better than one level does. Degrees of freedom of the pooled
// variance: n (tr V)^2 / tr(V^2), with the covariance V of the levels as the repeats show it, and n
// = repeats - 1 (Greenhouse and Geisser, Psychometrika 24 (1959) 95). They are at most n^2: where
// the levels scatter independently, the interval is wider than it would have to be. Unbiased
// estimates of the traces give more degrees of freedom, but then the interval holds in 84 % only
// where part of the scatter is common.
double freedom_of_repeats(const std::map<LevelKey, Point>& points) {
  std::map<std::pair<std::int32_t, std::int32_t>, double> products;  // of deviations
  std::set<std::int32_t> repeats;
  for (const auto& [key, p] : points) {
    for (const auto& [a, of_a] : p.of_repeat) {
      repeats.insert(a);
      for (const auto& [b, of_b] : p.of_repeat) {
        products[{a, b}] += (of_a - p.capacitance.mean) * (of_b - p.capacitance.mean);
      }
    }
  }
  const double n = std::max(1.0, static_cast<double>(repeats.size()) - 1);
  double trace = 0, squares = 0;
  for (const auto& [pair, product] : products) {
    if (pair.first == pair.second) trace += product / n;
    squares += product / n * product / n;
  }
  return squares > 0 ? std::max(n, n * trace * trace / squares) : n;
}

void calc_repeatability(const std::map<LevelKey, Point>& points, double confidence,
                        CurveResult& out) {
  out.repeatability_range = metric("repeatability_range", "%",
                                   "largest difference between repeats at one level (max - min of "
                                   "the levels' means), over the span of the curve");
  out.repeatability_2sigma = metric("repeatability_2sigma", "%",
                                    "twice the standard deviation of a level's mean between "
                                    "repeats (pooled over the levels), over the span of the curve");
  double squares = 0, freedom = 0, range = 0;
  std::int64_t rows = 0;
  for (const auto& [key, p] : points) {
    if (p.capacitance.count < 2) continue;
    squares += p.capacitance.sum_squares;
    freedom += static_cast<double>(p.capacitance.count - 1);
    range = std::max(range, p.high_pF - p.low_pF);
    rows += p.readings;
  }
  const double span = span_of_curve_fF(out);
  if (freedom < 1 || span <= 0) {
    out.repeatability_range.reason = out.repeatability_2sigma.reason =
        "no level was measured in two repeats";
    return;
  }
  const double two_sigma = 2 * std::sqrt(squares / freedom) * 1e3 / span * 100;
  out.repeatability_range.estimate = Estimate(range * 1e3 / span * 100);
  out.repeatability_2sigma.estimate =
      estimate_of_deviation(two_sigma, freedom_of_repeats(points), confidence);
  out.repeatability_range.rows = out.repeatability_2sigma.rows = rows;
}

}  // namespace

CurveResult calc_curve(const LevelResults& levels, const Metric& c0, double confidence) {
  CurveResult out;
  const auto points = group(levels);
  out.curve = build_curve(points, c0);
  calc_linearity(levels.line_direction, out);
  calc_repeatability(points, confidence, out);
  return out;
}

}  // namespace lcrig
