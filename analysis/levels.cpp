// SPDX-License-Identifier: Apache-2.0
// The `measure` steps: mean, scatter, outliers; the curve over all repeats; how straight and how
// repeatable it is.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "analysis/replicates.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kListedOutliers = 1000;
// An outlier is so far out that a run without any would show one in a hundred runs.
constexpr double kFalseOutliers = 0.01;

struct Collected {
  RunningMean capacitance, time, force;
  double products = 0;  // of force and capacitance, about their means
  double time_products = 0;  // of time and capacitance
  std::size_t first = 0, last = 0;  // [first, last) of the readings
};

bool counts(const Scene& scene, const RunReading& r) {
  return r.index > 0 && r.level > 0 && scene.uses(r) && (r.has_force() || !scene.data.has_frame());
}

std::vector<Collected> collect(const Scene& scene) {
  const RunData& data = scene.data;
  std::vector<Collected> out(data.levels.size());
  for (std::size_t i = 0; i < data.readings.size(); ++i) {
    const RunReading& r = data.readings[i];
    if (!counts(scene, r) || static_cast<std::size_t>(r.level) > out.size()) continue;
    Collected& c = out[static_cast<std::size_t>(r.level - 1)];
    if (c.capacitance.count == 0) c.first = i;
    c.last = i + 1;
    const double above = r.capacitance_F - c.capacitance.mean;
    c.capacitance.add(r.capacitance_F);
    c.time.add(r.t_s);
    c.time_products += above * (r.t_s - c.time.mean);
    if (!r.has_force()) continue;
    c.force.add(r.force_N);
    c.products += above * (r.force_N - c.force.mean);
  }
  return out;
}

LevelResult result_of(const Scene& scene, const LevelRow& row, const Collected& c, double force_N) {
  LevelResult l;
  l.level = row.level;
  l.repeat = row.repeat;
  l.index = row.index;
  l.t_s = c.time.mean;
  if (row.target_pressure_Pa) l.target_kPa = *row.target_pressure_Pa * 1e-3;
  l.pressure_kPa = *scene.kPa(force_N);
  l.capacitance_pF = c.capacitance.mean * 1e12;
  l.readings = static_cast<std::int32_t>(c.capacitance.count);
  l.missing = std::max(0, row.planned_readings - l.readings);
  if (l.readings >= 2) {
    l.scatter_fF = std::sqrt(c.capacitance.variance()) * 1e15;
    l.standard_error_fF = *l.scatter_fF / std::sqrt(l.readings);
    const double kPa_per_N = *scene.kPa(1);
    if (c.time.sum_squares > 0) {
      l.trend_ss_fF2 = c.time_products * c.time_products / c.time.sum_squares * 1e30;
    }
    l.covariance_fF_kPa = c.products / (l.readings - 1) * 1e15 * kPa_per_N;
    if (c.force.count >= 2) l.pressure_scatter_kPa = std::sqrt(c.force.variance()) * kPa_per_N;
  }
  return l;
}

// Against the level before in the same repeat; the first one goes the way of the second.
void find_directions(std::vector<LevelResult>& levels) {
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const bool first = i == 0 || levels[i - 1].repeat != levels[i].repeat;
    const bool last = i + 1 == levels.size() || levels[i + 1].repeat != levels[i].repeat;
    if (first && last) continue;
    const std::size_t from = first ? i : i - 1;
    const auto pressure = [&levels](std::size_t k) {
      return levels[k].target_kPa.value_or(levels[k].pressure_kPa);
    };
    levels[i].direction = pressure(from + 1) < pressure(from) ? Direction::down : Direction::up;
  }
}

// Scatter of the levels between repeats when this part of the rests' deviations is followed.
std::optional<double> scatter_with(const Scene& scene, const RunAnalysis& out, double part) {
  Drift drift = scene.drift;
  drift.follow(part);
  auto points = all_points(out);
  std::vector<LinePoint> line;
  for (RangePoint& p : points) {
    p.at.y -= drift.at(p.t_s);
    line.push_back(p.at);
  }
  const auto fit = fit_line(line);
  if (!fit) return std::nullopt;
  const auto error = error_between_repeats(points, fit->slope);
  return error ? std::optional(error->variance) : std::nullopt;
}

// A capacitance that steps when the specimen is touched anew lets the rests deviate from a line,
// too, but what lies between them does not follow: then following would only add scatter.
void subtract_drift(Scene& scene, RunAnalysis& out) {
  const double part = scene.drift.followed();
  if (part > 0) {
    const auto with = scatter_with(scene, out, part), without = scatter_with(scene, out, 0);
    if (with && without && *without < *with) scene.drift.follow(0);
  }
  for (LevelResult& l : out.levels) {
    l.drift_fF = scene.drift.at(l.t_s);
    l.capacitance_pF -= l.drift_fF * 1e-3;
  }
}

// Every reading against the median of its level, in pooled robust standard deviations.
void find_outliers(const Scene& scene, const std::vector<Collected>& collected, RunAnalysis& out) {
  const auto& readings = scene.data.readings;
  std::vector<double> medians(collected.size()), all;
  std::vector<double> values;
  for (std::size_t k = 0; k < collected.size(); ++k) {
    if (collected[k].capacitance.count < 4) continue;
    values.clear();
    for (std::size_t i = collected[k].first; i < collected[k].last; ++i) {
      if (counts(scene, readings[i])) values.push_back(readings[i].capacitance_F);
    }
    medians[k] = median(values);
    for (const double v : values) all.push_back(v - medians[k]);
  }
  const double sigma = robust_sigma(all);
  if (sigma <= 0) return;
  const double tail = kFalseOutliers / (2 * static_cast<double>(all.size()));
  const double limit = std::max(3.5, -normal_quantile(tail));
  for (LevelResult& l : out.levels) {
    const auto k = static_cast<std::size_t>(l.level - 1);
    if (collected[k].capacitance.count < 4) continue;
    for (std::size_t i = collected[k].first; i < collected[k].last; ++i) {
      const RunReading& r = readings[i];
      if (!counts(scene, r)) continue;
      const double z = (r.capacitance_F - medians[k]) / sigma;
      if (std::abs(z) <= limit) continue;
      ++l.outliers;
      ++out.outlier_count;
      out.outliers.push_back({r.t_s, r.level, r.index, r.capacitance_F * 1e12,
                              (r.capacitance_F - medians[k]) * 1e15, z});
    }
  }
}

// Likewise the baseline, against its own median and scatter.
void find_outliers_of_baseline(const Scene& scene, RunAnalysis& out) {
  const auto& nodes = scene.drift.nodes();
  if (nodes.empty()) return;
  std::vector<double> values;
  for (std::size_t i = nodes.front().first; i < nodes.front().last; ++i) {
    const RunReading& r = scene.data.readings[i];
    if (scene.uses(r)) values.push_back(r.capacitance_F);
  }
  const double middle = median(values), sigma = robust_sigma(values);
  if (sigma <= 0) return;
  const double tail = kFalseOutliers / (2 * static_cast<double>(values.size()));
  const double limit = std::max(3.5, -normal_quantile(tail));
  for (std::size_t i = nodes.front().first; i < nodes.front().last; ++i) {
    const RunReading& r = scene.data.readings[i];
    const double z = (r.capacitance_F - middle) / sigma;
    if (!scene.uses(r) || std::abs(z) <= limit) continue;
    ++out.outlier_count;
    out.outliers.push_back(
        {r.t_s, 0, 0, r.capacitance_F * 1e12, (r.capacitance_F - middle) * 1e15, z});
  }
}

void keep_largest_outliers(std::vector<Outlier>& outliers) {
  std::sort(outliers.begin(), outliers.end(), [](const Outlier& a, const Outlier& b) {
    return std::abs(a.deviations) > std::abs(b.deviations);
  });
  if (outliers.size() > kListedOutliers) outliers.resize(kListedOutliers);
}

struct Point {
  RunningMean capacitance;  // pF, of the levels' means
  double weighted_pF = 0, weighted_kPa = 0;
  double variance_of_sum = 0;  // of weighted_pF, from the scatter of the readings
  std::int64_t readings = 0;
  double low_pF = 0, high_pF = 0;
};

std::map<LevelKey, Point> group(const RunAnalysis& out) {
  std::map<LevelKey, Point> points;
  for (const LevelResult& l : out.levels) {
    Point& p = points[key_of(l)];
    if (p.readings == 0) p.low_pF = p.high_pF = l.capacitance_pF;
    p.low_pF = std::min(p.low_pF, l.capacitance_pF);
    p.high_pF = std::max(p.high_pF, l.capacitance_pF);
    p.capacitance.add(l.capacitance_pF);
    p.weighted_pF += l.readings * l.capacitance_pF;
    p.weighted_kPa += l.readings * l.pressure_kPa;
    const double se = l.standard_error_fF.value_or(0) * 1e-3 * l.readings;
    p.variance_of_sum += se * se;
    p.readings += l.readings;
  }
  return points;
}

// Between the repeats when there are some; a C0 that moves between them is part of it.
std::optional<double> error_of(const Point& p) {
  const auto repeats = static_cast<double>(p.capacitance.count);
  if (repeats >= 2) return std::sqrt(p.capacitance.variance() / repeats) * 1e3;
  if (p.variance_of_sum > 0) {
    return std::sqrt(p.variance_of_sum) / static_cast<double>(p.readings) * 1e3;
  }
  return std::nullopt;
}

void build_curve(const std::map<LevelKey, Point>& points, RunAnalysis& out) {
  for (const auto& [key, p] : points) {
    CurvePoint c;
    c.direction = key.direction;
    const auto n = static_cast<double>(p.readings);
    c.pressure_kPa = p.weighted_kPa / n;
    c.capacitance_pF = p.weighted_pF / n;
    if (out.c0) c.delta_C_fF = (c.capacitance_pF - out.c0.value()) * 1e3;
    c.standard_error_fF = error_of(p);
    c.repeats = static_cast<std::int32_t>(p.capacitance.count);
    c.readings = p.readings;
    out.curve.push_back(c);
  }
  std::sort(out.curve.begin(), out.curve.end(), [](const CurvePoint& a, const CurvePoint& b) {
    return a.direction != b.direction ? a.direction < b.direction : a.pressure_kPa < b.pressure_kPa;
  });
}

std::vector<LinePoint> line_points(const RunAnalysis& out) {
  std::vector<LinePoint> points;
  for (const CurvePoint& c : out.curve) {
    if (c.direction == direction_of_line(out)) {
      points.push_back({c.pressure_kPa, c.capacitance_pF * 1e3, 1});
    }
  }
  return points;
}

double span_of_curve_fF(const RunAnalysis& out) {
  double low = 0, high = 0;
  bool first = true;
  for (const CurvePoint& c : out.curve) {
    low = first ? c.capacitance_pF : std::min(low, c.capacitance_pF);
    high = first ? c.capacitance_pF : std::max(high, c.capacitance_pF);
    first = false;
  }
  return (high - low) * 1e3;
}

double mean_square_error(const RunAnalysis& out) {
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

void calc_linearity(RunAnalysis& out) {
  out.linearity = metric("linearity_percent",
                         "largest deviation of the curve from its best straight line over all "
                         "levels, over the span of the curve");
  out.linearity_terminal = metric("linearity_terminal_percent",
                                  "the same against the line through the first and last level");
  const auto points = line_points(out);
  const auto line = fit_line(points);
  const double span = span_of_curve_fF(out);
  if (!line || line->distinct_x < 3 || span <= 0) {
    out.linearity.reason = out.linearity_terminal.reason = "it takes three different pressures";
    return;
  }
  const double error = std::sqrt(mean_square_error(out)) / span * 100;
  const auto set = [&](Metric& m, double deviation) {
    Estimate e;
    e.value = deviation / span * 100;
    if (error > 0) e.standard_error = error;
    m.estimate = e;
    for (const CurvePoint& c : out.curve) m.rows += c.readings;
  };
  set(out.linearity, largest_deviation(points, line->slope, line->x_mean, line->y_mean));
  const LinePoint &a = points.front(), &b = points.back();
  set(out.linearity_terminal, largest_deviation(points, (b.y - a.y) / (b.x - a.x), a.x, a.y));
  if (mean_square_error(out) > 0 && out.linearity.value() < 2 * error) {
    out.linearity.reason = "no larger than the scatter of the levels makes it";
  }
}

void calc_repeatability(const Scene& scene, const std::map<LevelKey, Point>& points,
                        RunAnalysis& out) {
  out.repeatability_range = metric("repeatability_range_percent",
                                   "largest difference between repeats at one level (max - min of "
                                   "the levels' means), over the span of the curve");
  out.repeatability_2sigma = metric("repeatability_2sigma_percent",
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
  Estimate e;
  e.value = range * 1e3 / span * 100;
  out.repeatability_range.estimate = e;
  out.repeatability_2sigma.estimate =
      estimate(two_sigma, two_sigma / std::sqrt(2 * freedom), freedom, scene.options.confidence);
  out.repeatability_range.rows = out.repeatability_2sigma.rows = rows;
}

}  // namespace

std::string_view to_string(PeakMethod m) {
  switch (m) {
    case PeakMethod::fit: return "fit to the force";
    case PeakMethod::plateau: return "mean of the plateau";
    case PeakMethod::nearest: return "nearest reading";
  }
  return "";
}

std::string_view to_string(Direction d) {
  return d == Direction::up ? "up" : "down";
}

LevelKey key_of(const LevelResult& level) {
  const std::int64_t what =
      level.target_kPa ? std::llround(*level.target_kPa * 1e4) : std::int64_t{level.index};
  return {level.direction, what};
}

Direction direction_of_line(const RunAnalysis& out) {
  const auto up = std::count_if(out.levels.begin(), out.levels.end(),
                                [](const LevelResult& l) { return l.direction == Direction::up; });
  return 2 * up >= std::ssize(out.levels) ? Direction::up : Direction::down;
}

void calc_levels(Scene& scene, RunAnalysis& out) {
  if (scene.data.levels.empty()) return;
  if (!scene.data.area_m2) {
    out.notes.emplace_back(
        "the run knows no probe diameter, so there are no pressures and no levels in kPa; state it "
        "in the fixture of the bench or config file");
    return;
  }
  const auto collected = collect(scene);
  std::int64_t without_force = 0;
  for (std::size_t i = 0; i < collected.size(); ++i) {
    const Collected& c = collected[i];
    const LevelRow& row = scene.data.levels[i];
    if (c.capacitance.count == 0) continue;
    if (c.force.count == 0 && !row.target_force_N) continue;
    if (c.force.count == 0) ++without_force;
    const double force = c.force.count > 0 ? c.force.mean : *row.target_force_N;
    out.levels.push_back(result_of(scene, row, c, force));
  }
  if (without_force > 0) {
    out.notes.push_back(fmt::format(
        "{} levels have no recorded force: the force that was asked for is taken", without_force));
  }
  find_directions(out.levels);
  subtract_drift(scene, out);
  find_outliers(scene, collected, out);
  find_outliers_of_baseline(scene, out);
  keep_largest_outliers(out.outliers);
}

void calc_curve(const Scene& scene, RunAnalysis& out) {
  if (out.c0) {
    for (LevelResult& l : out.levels) l.delta_C_fF = (l.capacitance_pF - out.c0.value()) * 1e3;
  }
  const auto points = group(out);
  build_curve(points, out);
  calc_linearity(out);
  calc_repeatability(scene, points, out);
}

}  // namespace lcrig
