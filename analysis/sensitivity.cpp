// SPDX-License-Identifier: Apache-2.0
// Slopes in ranges of pressure, from levels or from the loading branches of continuous cycles.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "analysis/least_squares.hpp"
#include "analysis/replicates.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr const char* kOfLevels =
    "slope of C against pressure: least squares over the levels' means in the range, weighted "
    "with their planned number of readings, sums about the means, drift subtracted; the interval "
    "for the least-squares slope of the curve that this rig would show at the same pressures "
    "without noise, drift and difference of repeats; the expanded uncertainty for the specimen's "
    "own";
// In standard deviations: Huber's location gives a reading beyond it less than half of its weight.
constexpr double kDownWeighted = 2.69;
constexpr std::size_t kCurve = 4;  // parameters of the smooth curve, a cubic
constexpr std::size_t kLeastForCurve = 6;  // fewest levels: two more than the parameters

// The points that a slope is fitted to.
struct Input {
  std::vector<RangePoint> points;
  std::vector<LinePoint> line;
  std::int64_t rows = 0;
};

void set_points(Input& in, std::vector<RangePoint> points) {
  in.points = without_offsets(std::move(points));
  weigh_as_planned(in.points);
  in.line.clear();
  for (const RangePoint& p : in.points) in.line.push_back({p.at.x, p.at.y, p.line_weight});
}

// The requested pressure decides, because the measured one scatters about the edge of a range.
Input input_of(const LevelResults& levels, const PressureRange& range) {
  Input in;
  for (const LevelResult& l : levels.levels) {
    if (l.direction != levels.line_direction ||
        !is_inside(range, l.target_kPa.value_or(l.pressure_kPa))) {
      continue;
    }
    in.points.push_back(point_of(l));
    if (!range.only_kPa.empty()) in.points.back().planned = 1;
    in.rows += l.readings;
  }
  set_points(in, std::move(in.points));
  return in;
}

int count_pressures(const std::vector<RangePoint>& points) {
  std::map<LevelKey, int> keys;
  for (const RangePoint& p : points) ++keys[p.key];
  return static_cast<int>(keys.size());
}

// The pressures to which the slope refers, and their weights in it.
std::vector<LoadState::Pressure> pressures_of(const LevelResults& levels,
                                              const std::vector<RangePoint>& points) {
  std::map<std::int32_t, double> asked_kPa;
  for (const LevelResult& l : levels.levels) {
    asked_kPa[l.level] = l.target_kPa.value_or(l.pressure_kPa);
  }
  struct Means {
    RunningMean asked, measured;
    double weight = 0;
  };
  std::map<LevelKey, Means> means;
  double sum = 0;
  for (const RangePoint& p : points) {
    Means& m = means[p.key];
    m.asked.add(asked_kPa[p.level]);
    m.measured.add(p.at.x);
    m.weight += p.line_weight;
    sum += p.line_weight;
  }
  std::vector<LoadState::Pressure> out;
  out.reserve(means.size());
  for (const auto& [key, m] : means) {
    out.push_back({m.asked.mean, m.measured.mean, m.weight / sum});
  }
  std::ranges::sort(out, {}, &LoadState::Pressure::kPa);
  return out;
}

// Mean of each pressure, sorted by pressure: the shape of the curve without the scatter of repeats.
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
  out.reserve(groups.size());
  for (const auto& [key, g] : groups) out.push_back(g);
  std::ranges::sort(out, {}, &LinePoint::x);
  return out;
}

// Describes the residuals of the means. They are bent if those of the middle third lie on the other
// side of the line than those of the ends.
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
  if (error && freedom >= 1 && error->variance > 0) {
    r.lack_of_fit_p = f_tail(ss / freedom / error->variance, freedom, error->degrees_of_freedom);
  }
  if (residuals.size() >= 6) r.runs_p = runs_test(residuals).p;
  r.residual_pattern = describe_pattern(residuals, r);
}

// Tests whether the slopes of the repeats differ by more than the scatter within levels explains.
void add_repeats(const Input& in, const SlopeScatter& scatter, RangeResult& r) {
  r.slope_of_repeat = scatter.slopes;
  const auto within = error_within_levels(in.points, r.sensitivity.value());
  if (!scatter.of_slopes || !within || within->variance <= 0) return;
  const PureError& slopes = *scatter.of_slopes;
  r.between_repeats_p = f_tail(slopes.variance / within->variance, slopes.degrees_of_freedom,
                               within->degrees_of_freedom);
  if (*r.between_repeats_p < 0.001) {
    add_remark(r.sensitivity.reason,
               "the slopes of the repeats differ more than the readings scatter: the interval is "
               "that of the repeats");
  }
}

void add_line(const LineFit& line, const Metric& c0, RangeResult& r) {
  if (line.syy > 0) r.r_squared = line.r_squared;
  r.mean_kPa = line.x_mean;
  r.residual_fF = std::sqrt(line.residual_ss / line.sum_weights);
  if (!c0) return;
  r.mean_delta_C_fF = line.y_mean - c0.value() * 1e3;
  r.intercept_fF = *r.mean_delta_C_fF - line.slope * line.x_mean;
}

// The same least squares over Huber's location of each level's readings instead of their mean.
void add_robust(const SlopeBasis& basis, const Input& in, RangeResult& r) {
  const Scene& scene = basis.scene;
  std::map<std::int32_t, std::vector<double>> values;
  for (const RangePoint& p : in.points) values[p.level];
  for (const RunReading& reading : scene.data.readings) {
    if (reading.index <= 0 || !scene.uses(reading)) continue;
    const auto it = values.find(reading.level);
    if (it != values.end()) it->second.push_back(scene.fF(reading));
  }
  RobustSlope robust;
  std::vector<RangePoint> points = in.points;
  for (std::size_t i = 0; i < in.points.size(); ++i) {
    const auto& v = values[in.points[i].level];
    if (v.empty()) return;
    const double at = huber_location(v), sigma = robust_sigma(v);
    points[i].at.y = at;
    robust.down_weighted += static_cast<std::int32_t>(std::count_if(
        v.begin(), v.end(), [&](double y) { return std::abs(y - at) > kDownWeighted * sigma; }));
  }
  Input robust_in;
  set_points(robust_in, std::move(points));
  const auto line = fit_line(robust_in.line);
  if (!line) return;
  robust.slope_fF_per_kPa = line->slope;
  const auto scatter = scatter_of_slope(scene, robust_in.points, all_points(basis.levels), *line);
  if (scatter) robust.standard_error = line->slope_se(scatter->error.variance);
  r.robust = robust;
}

// Adds a caveat where outliers move the mean.
void remark_on_outliers(const LevelResults& levels, const Input& in, RangeResult& r) {
  std::int64_t outliers = 0;
  for (const LevelResult& l : levels.levels) {
    const auto mine = std::any_of(in.points.begin(), in.points.end(),
                                  [&l](const RangePoint& p) { return p.level == l.level; });
    if (mine) outliers += l.outliers;
  }
  if (outliers == 0 || !r.robust || !r.sensitivity.estimate) return;
  const double moved = r.sensitivity.value() - r.robust->slope_fF_per_kPa;
  if (std::abs(moved) <= 2 * r.robust->standard_error) return;
  add_remark(r.sensitivity.reason,
             fmt::format("{} outliers among its readings move it by {:.3g}: without their weight "
                         "(robust) it is {:.6g} fF/kPa",
                         outliers, moved, r.robust->slope_fF_per_kPa));
}

// Adds a caveat where a level is missing in all repeats: the slope is that of another part then.
void remark_on_missing_levels(const SlopeBasis& basis, const Input& in, RangeResult& r) {
  std::map<LevelKey, int> repeats_with;
  std::set<std::int32_t> repeats;
  for (const RangePoint& p : in.points) {
    ++repeats_with[p.key];
    repeats.insert(p.repeat);
  }
  constexpr double kDigit_kPa = 1e-4;  // step to which requested pressures are rounded
  std::set<std::int64_t> known, without;
  for (const LevelResult& l : basis.levels.levels) {
    if (l.target_kPa) known.insert(std::llround(*l.target_kPa / kDigit_kPa));
  }
  for (const LevelRow& row : basis.scene.data.levels) {
    if (!row.target_pressure_Pa || !is_inside(r.range, *row.target_pressure_Pa * 1e-3)) continue;
    const std::int64_t what = std::llround(*row.target_pressure_Pa * 1e-3 / kDigit_kPa);
    if (!known.contains(what)) without.insert(what);
  }
  std::string absent;
  for (const std::int64_t what : without) {
    absent +=
        fmt::format("{}{:g}", absent.empty() ? "" : ", ", static_cast<double>(what) * kDigit_kPa);
  }
  if (!absent.empty()) {
    add_remark(
        r.sensitivity.reason,
        fmt::format("no reading at {} kPa: the slope is that of the other pressures", absent));
  }
  const auto lacking = std::ranges::count_if(
      repeats_with, [&](const auto& level) { return level.second < std::ssize(repeats); });
  if (lacking > 0) {
    add_remark(r.sensitivity.reason,
               fmt::format("{} of {} pressures are missing in some repeats: they count as much as "
                           "the others",
                           lacking, repeats_with.size()));
  }
}

void set_slope(const Scene& scene, const Input& in, const LineFit& line,
               const std::optional<SlopeScatter>& scatter, RangeResult& r) {
  if (!scatter) {
    r.sensitivity.estimate = Estimate(line.slope);
    r.sensitivity.reason = "two points without repeats or readings: no scatter, no interval";
    return;
  }
  const PureError& error = scatter->error;
  const SlopePart own{line.slope_se(error.variance), error.degrees_of_freedom};
  SlopePart drift;
  if (!scatter->one_repeat && scene.drift.known()) {  // one repeat: the scatter has the rests
    std::vector<LinePoint> times;
    times.reserve(in.points.size());
    for (const RangePoint& p : in.points) times.push_back({p.at.x, p.t_s, p.line_weight});
    const double s_per_kPa = fit_line(times)->slope;
    drift = {std::abs(s_per_kPa) * scene.drift.rate_se_fF_s() * (1 - scene.drift.followed()),
             scene.drift.rate_freedom()};
  }
  r.parts_of_error = {own, drift};
  r.sensitivity.estimate =
      estimate_of_parts(line.slope, r.parts_of_error, scene.options.confidence);
  r.scatter_basis = error.basis;
  if (!(*r.sensitivity.estimate->standard_error > 0)) {
    add_remark(r.sensitivity.reason,
               "nothing scatters: an interval of no width is not an honest one, look at the "
               "resolution of the readings");
  }
  if (scatter->one_repeat) add_remark(r.sensitivity.reason, kOneRepeat);
}

// Estimates scatter that all repeats share (from seating, probe, electrode) and that looks like the
// shape of the curve. It is the deviation of the levels' means from a smooth curve through all of
// them, as far as the scatter between repeats does not explain it.
void add_shared(const LevelResults& results, const Input& in, const LineFit& line,
                const std::optional<SlopeScatter>& scatter, RangeResult& r) {
  const auto levels = means(without_offsets(all_points(results)));
  if (levels.size() < kLeastForCurve) return;
  const double low = levels.front().x, high = levels.back().x;
  LeastSquares curve(kCurve);
  double readings = 0;
  for (const LinePoint& p : levels) {
    const double v = 2 * (p.x - low) / (high - low) - 1;
    const double row[kCurve] = {1, v, v * v, v * v * v};
    curve.add(row, p.y);
    readings += 1 / p.weight / static_cast<double>(levels.size());
  }
  const auto fit = curve.solve();
  if (!fit || fit->freedom < 1) return;
  const double scatter_of_mean =
      scatter && scatter->of_levels ? scatter->of_levels->variance * readings : 0;
  const double shared = std::max(0.0, fit->residual_ss / fit->freedom - scatter_of_mean);
  std::map<LevelKey, double> factor;
  for (const RangePoint& p : in.points) {
    factor[p.key] += p.line_weight * (p.at.x - line.x_mean) / line.sxx;
  }
  double unit = 0;
  for (const auto& [key, f] : factor) unit += f * f;
  r.shared = SlopePart{std::sqrt(shared * unit), fit->freedom};
}

RangeResult of_levels(const SlopeBasis& basis, const PressureRange& range) {
  const Scene& scene = basis.scene;
  const LevelResults& levels = basis.levels;
  RangeResult r;
  r.range = range;
  r.sensitivity = metric("sensitivity", "fF/kPa", kOfLevels);
  const Input in = input_of(levels, range);
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
  const auto scatter = scatter_of_slope(scene, in.points, all_points(levels), *line);
  set_slope(scene, in, *line, scatter, r);
  add_line(*line, basis.baseline.c0, r);
  add_shape(in, *line, scatter ? scatter->of_levels : std::nullopt, r);
  if (scatter) add_repeats(in, *scatter, r);
  add_robust(basis, in, r);
  remark_on_outliers(levels, in, r);
  remark_on_missing_levels(basis, in, r);
  add_shared(levels, in, *line, scatter, r);
  name_estimand(scene, levels, range, r.sensitivity);
  r.sensitivity.load->pressures = pressures_of(levels, in.points);
  return r;
}

RangeResult slope_in(const SlopeBasis& basis, const PressureRange& range) {
  const RunData& data = basis.scene.data;
  if (!basis.levels.levels.empty()) return of_levels(basis, range);
  if (data.area_m2 && !basis.cycles.cycles.empty()) return slope_of_cycles(basis, range);
  RangeResult r;
  r.range = range;
  r.sensitivity = metric("sensitivity", "fF/kPa", kOfLevels);
  r.sensitivity.reason =
      !data.area_m2       ? "no pressures: the run knows no probe diameter (see force_sensitivity)"
      : !data.has_frame() ? "no pressures: no force was recorded"
                          : "no levels were measured and no loading was found";
  return r;
}

// Slope over all levels of a region. The region is named by its outermost levels.
RangeResult of_region(const SlopeBasis& basis, const PressureRange& range,
                      const PressureRange& known_as) {
  RangeResult r = of_levels(basis, range);
  r.range = known_as;
  r.uncertainty = uncertainty_of(basis, r);
  return r;
}

RegionSearch search(const SlopeBasis& basis) {
  RegionSearch s;
  if (basis.levels.levels.empty()) {
    s.reason = "the search for two regions needs levels";
    return s;
  }
  std::vector<LinePoint> points;
  for (const CurvePoint& c : basis.curve.curve) {
    if (c.direction == basis.levels.line_direction) {
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
  s.low = of_region(basis, {points.front().x - 1, middle}, {points.front().x, s.low_to_kPa});
  s.high = of_region(basis, {middle, points.back().x + 1}, {s.high_from_kPa, points.back().x});
  s.p_one_line = found->p_one_line;
  return s;
}

Metric limit_of_detection(const SlopeBasis& basis, const std::vector<RangeResult>& ranges) {
  Metric m = metric("limit_of_detection", "kPa",
                    "three standard deviations of one reading over the sensitivity of 0-30 kPa "
                    "(without it, of the lowest range that was asked for)");
  // Always uses the same range, so that asking for other ranges does not change the result.
  const RangeResult usual = slope_in(basis, AnalysisOptions().ranges.front());
  const RangeResult* lowest = usual.sensitivity ? &usual : nullptr;
  for (const RangeResult& r : ranges) {
    if (usual.sensitivity || !r.sensitivity) continue;
    if (lowest == nullptr || r.range.from_kPa < lowest->range.from_kPa) lowest = &r;
  }
  const Metric& noise = basis.baseline.noise;
  if (lowest == nullptr || !noise) {
    m.reason = noise ? "no sensitivity is known" : "the noise of a reading is not known";
    return m;
  }
  if (lowest->sensitivity.value() == 0 || !(noise.value() > 0)) {
    m.reason = "it takes a noise and a sensitivity that are not 0";
    return m;
  }
  const Estimate& slope = *lowest->sensitivity.estimate;
  const double value = 3 * noise.value() / std::abs(slope.value);
  m.estimate = Estimate(value);
  if (slope.standard_error) {
    const auto scaled = [&](const Estimate& of) {
      return SlopePart{value * std::abs(*of.standard_error / of.value),
                       of.degrees_of_freedom.value_or(1)};
    };
    m.estimate = estimate_of_parts(value, {scaled(*noise.estimate), scaled(slope)},
                                   basis.scene.options.confidence);
  }
  m.rows = lowest->sensitivity.rows + noise.rows;
  m.reason = fmt::format("with the slope of {}", range_text(lowest->range));
  if (slope.standard_error && lowest->slope_of_repeat.size() < 2) {
    const char* what = basis.levels.levels.empty() ? "cycle" : "repeat";
    add_remark(m.reason, fmt::format("one {0}: the interval knows nothing of what differs between "
                                     "{0}s",
                                     what));
  }
  return m;
}

}  // namespace

SensitivityResult calc_sensitivity(const SlopeBasis& basis) {
  const AnalysisOptions& options = basis.scene.options;
  SensitivityResult out;
  for (const PressureRange& range : options.ranges) {
    RangeResult& r = out.ranges.emplace_back(slope_in(basis, range));
    r.uncertainty = uncertainty_of(basis, r);
  }
  if (options.search_regions) out.regions = search(basis);
  out.limit_of_detection = limit_of_detection(basis, out.ranges);
  return out;
}

}  // namespace lcrig
