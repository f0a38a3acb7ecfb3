// SPDX-License-Identifier: Apache-2.0
// Slopes in ranges of pressure: from levels, or from the loading branches of continuous cycles.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "analysis/replicates.hpp"

namespace lcrig {

namespace {

constexpr const char* kName = "sensitivity_fF_per_kPa";
constexpr const char* kOfLevels =
    "slope of C against pressure: least squares over the levels' means in the range, weighted with "
    "their number of readings, sums about the means; the interval from scatter that knows nothing "
    "of the shape of the curve, for the least-squares slope of the true curve at the same "
    "pressures";
constexpr const char* kOfCycles =
    "slope of C against pressure: least squares over the readings of the loading branches in the "
    "range, one level for each cycle; the interval from the scatter between cycles";
constexpr double kEdge = 1e-6;  // relative: a level at 30 kPa lies in 0-30 kPa

// What a fit needs, whatever the points are.
struct Input {
  std::vector<RangePoint> points;
  std::vector<LinePoint> line;
  std::int64_t rows = 0;
};

bool inside(const PressureRange& range, double kPa) {
  const double slack = kEdge * std::max(std::abs(range.to_kPa), 1.0);
  return kPa >= range.from_kPa - slack && kPa <= range.to_kPa + slack;
}

RangePoint point_of(const LevelResult& l) {
  RangePoint p;
  p.at = {l.pressure_kPa, l.capacitance_pF * 1e3, static_cast<double>(l.readings)};
  p.key = key_of(l);
  p.repeat = l.repeat;
  p.t_s = l.t_s;
  p.readings = l.readings;
  const double s = l.scatter_fF.value_or(0);
  p.reading_ss = (l.readings - 1) * s * s;
  return p;
}

std::vector<RangePoint> all_points(const RunAnalysis& out) {
  std::vector<RangePoint> points;
  const Direction direction = direction_of_line(out);
  for (const LevelResult& l : out.levels) {
    if (l.direction == direction) points.push_back(point_of(l));
  }
  return points;
}

// The pressure that was asked for decides: its reading scatters about the edge of a range.
Input input_of(const RunAnalysis& out, const PressureRange& range) {
  Input in;
  const Direction direction = direction_of_line(out);
  for (const LevelResult& l : out.levels) {
    if (l.direction != direction || !inside(range, l.target_kPa.value_or(l.pressure_kPa))) continue;
    in.points.push_back(point_of(l));
    in.line.push_back(in.points.back().at);
    in.rows += l.readings;
  }
  return in;
}

int count_pressures(const std::vector<RangePoint>& points) {
  std::map<LevelKey, int> keys;
  for (const RangePoint& p : points) ++keys[p.key];
  return static_cast<int>(keys.size());
}

// Mean of each pressure, in the order of pressure: the shape of the curve without its repeats.
std::vector<LinePoint> means(const std::vector<RangePoint>& points) {
  std::map<LevelKey, LinePoint> groups;
  for (const RangePoint& p : points) {
    auto [it, fresh] = groups.try_emplace(p.key, LinePoint{p.at.x, p.at.y, 0});
    LinePoint& g = it->second;
    g.weight += p.at.weight;
    g.x += p.at.weight / g.weight * (p.at.x - g.x);
    g.y += p.at.weight / g.weight * (p.at.y - g.y);
  }
  std::vector<LinePoint> out;
  for (const auto& [key, g] : groups) out.push_back(g);
  std::sort(out.begin(), out.end(),
            [](const LinePoint& a, const LinePoint& b) { return a.x < b.x; });
  return out;
}

// Residuals of the means: bent if those of the middle third lie on the other side than the ends.
std::string describe_pattern(const std::vector<double>& residuals, const RangeResult& r) {
  if (residuals.size() < 3) return "two pressures: a line fits always";
  if (!r.lack_of_fit_p || *r.lack_of_fit_p > 0.01) return "no pattern beyond the scatter";
  const double ends = residuals.front() + residuals.back();
  const char* shape = ends < 0 ? "bent down (the slope falls with pressure)"
                               : "bent up (the slope grows with pressure)";
  return fmt::format("{}: the straight line is an average, not the shape of the curve", shape);
}

void add_shape(const Input& in, const LineFit& line, const std::optional<PureError>& error,
               RangeResult& r) {
  const auto groups = means(in.points);
  std::vector<double> residuals;
  double ss = 0;
  for (const LinePoint& g : groups) {
    residuals.push_back(g.y - line.at(g.x));
    ss += g.weight * residuals.back() * residuals.back();
  }
  const auto freedom = static_cast<double>(groups.size()) - 2;
  const bool pure = error && !error->basis.starts_with("scatter about");
  if (pure && freedom >= 1 && error->variance > 0) {
    r.lack_of_fit_p = f_tail(ss / freedom / error->variance, freedom, error->degrees_of_freedom);
  }
  if (residuals.size() >= 6) r.runs_p = runs_test(residuals).p;
  r.residual_pattern = describe_pattern(residuals, r);
}

// Do the slopes of the repeats differ more than the scatter within the levels explains?
void add_repeats(const Input& in, double confidence, RangeResult& r) {
  std::map<std::int32_t, std::vector<LinePoint>> repeats;
  for (const RangePoint& p : in.points) repeats[p.repeat].push_back(p.at);
  std::vector<LineFit> lines;
  for (const auto& [repeat, points] : repeats) {
    const auto line = fit_line(points);
    if (!line) continue;
    lines.push_back(*line);
    r.slope_of_repeat.push_back(line->slope);
  }
  const auto within = error_within_levels(in.points);
  if (lines.size() < 2 || !within || within->variance <= 0) return;
  double weight = 0, mean = 0, ss = 0;
  for (const LineFit& l : lines) weight += l.sxx, mean += l.sxx * l.slope;
  mean /= weight;
  for (const LineFit& l : lines) ss += l.sxx * (l.slope - mean) * (l.slope - mean);
  const auto freedom = static_cast<double>(lines.size()) - 1;
  r.between_repeats_p =
      f_tail(ss / freedom / within->variance, freedom, within->degrees_of_freedom);
  if (*r.between_repeats_p < 0.001 && r.sensitivity.estimate) {
    const double se = std::sqrt(ss / freedom / weight);
    r.sensitivity.reason = fmt::format(
        "the slopes of the repeats differ more than the readings scatter; taken as one value each "
        "they would give +-{:.3g} fF/kPa",
        coverage_factor(confidence, freedom) * se);
  }
}

void add_line(const LineFit& line, const RunAnalysis& out, RangeResult& r) {
  r.r_squared = line.r_squared;
  r.mean_kPa = line.x_mean;
  r.residual_fF = std::sqrt(line.residual_ss / line.sum_weights);
  if (!out.c0) return;
  r.mean_delta_C_fF = line.y_mean - out.c0.value() * 1e3;
  r.intercept_fF = *r.mean_delta_C_fF - line.slope * line.x_mean;
}

// The readings of each level by Huber's location, then Huber's line.
void add_robust(const Scene& scene, const RunAnalysis& out, const PressureRange& range,
                RangeResult& r) {
  std::map<std::int32_t, std::vector<double>> values;
  std::map<std::int32_t, const LevelResult*> levels;
  const Direction direction = direction_of_line(out);
  for (const LevelResult& l : out.levels) {
    if (l.direction == direction && inside(range, l.target_kPa.value_or(l.pressure_kPa))) {
      levels[l.level] = &l;
    }
  }
  for (const RunReading& reading : scene.data.readings) {
    if (reading.index > 0 && levels.contains(reading.level) && scene.uses(reading)) {
      values[reading.level].push_back(reading.capacitance_F * 1e15);
    }
  }
  std::vector<LinePoint> points;
  for (const auto& [level, v] : values) {
    points.push_back(
        {levels[level]->pressure_kPa, huber_location(v), static_cast<double>(v.size())});
  }
  const auto fit = fit_line_huber(points);
  if (!fit) return;
  RobustSlope robust;
  robust.slope_fF_per_kPa = fit->line.slope;
  robust.standard_error = fit->slope_se;
  robust.down_weighted = static_cast<std::int32_t>(std::count_if(
      fit->huber_weights.begin(), fit->huber_weights.end(), [](double w) { return w < 1; }));
  r.robust = robust;
}

void set_slope(const Scene& scene, const LineFit& line, const std::optional<PureError>& error,
               RangeResult& r) {
  if (!error) {
    Estimate e;
    e.value = line.slope;
    r.sensitivity.estimate = e;
    r.sensitivity.reason = "two points without repeats or readings: no scatter, no interval";
    return;
  }
  r.sensitivity.estimate = estimate(line.slope, line.slope_se(error->variance),
                                    error->degrees_of_freedom, scene.options.confidence);
}

RangeResult of_levels(const Scene& scene, const RunAnalysis& out, const PressureRange& range) {
  RangeResult r;
  r.range = range;
  r.sensitivity = metric(kName, kOfLevels);
  const Input in = input_of(out, range);
  r.points = static_cast<std::int32_t>(in.points.size());
  r.pressures = count_pressures(in.points);
  r.sensitivity.rows = in.rows;
  if (r.pressures < 2) {
    r.sensitivity.reason =
        fmt::format("{} of the run's pressures lie in {}: a slope takes two different ones",
                    r.pressures, range_text(range));
    return r;
  }
  const auto line = fit_line(in.line);
  if (!line) {
    r.sensitivity.reason = line.error().what;
    return r;
  }
  const auto error = choose_error(in.points, all_points(out), *line);
  set_slope(scene, *line, error, r);
  add_line(*line, out, r);
  add_shape(in, *line, error, r);
  add_repeats(in, scene.options.confidence, r);
  add_robust(scene, out, range, r);
  if (error) r.scatter_basis = error->basis;
  return r;
}

// Readings of one loading branch.
struct Branch {
  std::vector<LinePoint> points;
  std::vector<LinePoint> rates;  // y: kPa/s
  double instant_s = 0;
};
Branch branch(const Scene& scene, const CycleResult& c, const PressureRange& range,
              Moving& moving) {
  Branch b;
  for (std::size_t i = c.first; i < c.last; ++i) {
    const RunReading& r = scene.data.readings[i];
    if (!moving(i) || r.t_s > c.peak_s || spans_turn(c, r)) continue;
    const double kPa = *scene.kPa(scene.above_rest_N(r));
    if (!inside(range, kPa)) continue;
    b.points.push_back({kPa, (r.capacitance_F * 1e12 - c.rest_pF) * 1e3, 1});
    b.rates.push_back({kPa, *scene.kPa(r.force_rate_N_s), 1});
    b.instant_s = std::max(b.instant_s, static_cast<double>(r.alignment_s));
  }
  return b;
}

struct CycleBranches {
  std::vector<LineFit> lines;
  double sxx = 0, sxy = 0, syy = 0, residual_ss = 0, weight = 0, x = 0, y = 0;
  double rate_sxy = 0, instant_s = 0;
};

CycleBranches fit_branches(const Scene& scene, const RunAnalysis& out, const PressureRange& range) {
  CycleBranches b;
  Moving moving(scene, out);
  for (const CycleResult& c : out.cycles) {
    const Branch readings = branch(scene, c, range, moving);
    const auto line = fit_line(readings.points);
    if (!line) continue;
    b.lines.push_back(*line);
    b.rate_sxy += fit_line(readings.rates)->sxy;
    b.instant_s = std::max(b.instant_s, readings.instant_s);
    b.sxx += line->sxx;
    b.sxy += line->sxy;
    b.syy += line->syy;
    b.weight += line->sum_weights;
    b.x += line->sum_weights * line->x_mean;
    b.y += line->sum_weights * line->y_mean;
  }
  const double slope = b.sxy / b.sxx;
  for (const LineFit& l : b.lines) {
    b.residual_ss += l.residual_ss + l.sxx * (l.slope - slope) * (l.slope - slope);
  }
  return b;
}

// One slope for all cycles, each with its own level; its scatter between the cycles knows nothing
// of the shape of the curve. Two cycles or one: the scatter about the lines.
PureError branch_error(const CycleBranches& b, double slope) {
  const auto cycles = static_cast<double>(b.lines.size());
  if (cycles >= 3) {
    double ss = 0;
    for (const LineFit& l : b.lines) ss += l.sxx * (l.slope - slope) * (l.slope - slope);
    return {ss / (cycles - 1), cycles - 1,
            fmt::format("scatter of the slopes of {} cycles", b.lines.size())};
  }
  const double freedom = b.weight - cycles - 1;
  return {b.residual_ss / freedom, freedom,
          "scatter about the line, the curve's own shape included"};
}

RangeResult of_cycles(const Scene& scene, const RunAnalysis& out, const PressureRange& range) {
  RangeResult r;
  r.range = range;
  r.sensitivity = metric(kName, kOfCycles);
  const CycleBranches b = fit_branches(scene, out, range);
  r.sensitivity.rows = static_cast<std::int64_t>(b.weight);
  r.points = static_cast<std::int32_t>(b.weight);
  const auto parameters = static_cast<double>(b.lines.size()) + 1;
  if (b.lines.empty() || b.weight <= parameters) {
    r.sensitivity.reason =
        fmt::format("too few readings in {} while the load grew", range_text(range));
    return r;
  }
  r.pressures = r.points;
  const double slope = b.sxy / b.sxx;
  const PureError error = branch_error(b, slope);
  r.sensitivity.estimate = estimate(slope, std::sqrt(error.variance / b.sxx),
                                    error.degrees_of_freedom, scene.options.confidence);
  r.scatter_basis = error.basis;
  r.r_squared = b.syy > 0 ? std::max(0.0, 1 - b.residual_ss / b.syy) : 1;
  r.residual_fF = std::sqrt(b.residual_ss / b.weight);
  r.mean_kPa = b.x / b.weight;
  r.mean_delta_C_fF = b.y / b.weight;
  r.intercept_fF = *r.mean_delta_C_fF - slope * *r.mean_kPa;
  for (const LineFit& l : b.lines) r.slope_of_repeat.push_back(l.slope);
  r.rate_tilt_per_s = b.rate_sxy / b.sxx;
  r.instant_s = b.instant_s;
  r.residual_pattern = "continuous loading: see the loops";
  return r;
}

RangeResult calc_range(const Scene& scene, const RunAnalysis& out, const PressureRange& range) {
  if (!out.levels.empty()) return of_levels(scene, out, range);
  if (scene.data.area_m2 && !out.cycles.empty()) return of_cycles(scene, out, range);
  RangeResult r;
  r.range = range;
  const char* why = !scene.data.area_m2
                        ? "no pressures: the run knows no probe diameter (see force_sensitivity)"
                    : !scene.data.has_frame() ? "no pressures: no force was recorded"
                                              : "no levels were measured and no loading was found";
  r.sensitivity = missing(kName, kOfLevels, why);
  return r;
}

RegionSearch search(const Scene& scene, const RunAnalysis& out) {
  RegionSearch s;
  if (out.levels.empty()) {
    s.reason = "the search for two regions needs levels";
    return s;
  }
  std::vector<LinePoint> points;
  for (const CurvePoint& c : out.curve) {
    if (c.direction == direction_of_line(out)) {
      points.push_back({c.pressure_kPa, c.capacitance_pF * 1e3, static_cast<double>(c.readings)});
    }
  }
  const auto found = find_two_regions(points);
  if (!found) {
    s.reason = found.error().what;
    return s;
  }
  s.low_to_kPa = found->last_low_x;
  s.high_from_kPa = found->first_high_x;
  const double middle = (s.low_to_kPa + s.high_from_kPa) / 2;
  s.low = of_levels(scene, out, {points.front().x - 1, middle});
  s.high = of_levels(scene, out, {middle, points.back().x + 1});
  s.low.range = {points.front().x, s.low_to_kPa};
  s.high.range = {s.high_from_kPa, points.back().x};
  s.p_one_line = found->p_one_line;
  return s;
}

}  // namespace

void calc_sensitivity(const Scene& scene, RunAnalysis& out) {
  for (const PressureRange& range : scene.options.ranges) {
    out.ranges.push_back(calc_range(scene, out, range));
  }
  if (scene.options.search_regions) out.regions = search(scene, out);
}

}  // namespace lcrig
