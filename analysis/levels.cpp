// SPDX-License-Identifier: Apache-2.0
// Collects the `measure` steps: mean and scatter of each level.
#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/outliers.hpp"
#include "analysis/replicates.hpp"

namespace lcrig {

namespace {

struct Collected {
  RunningMean capacitance, time, force;
  double products = 0;  // of force and capacitance, relative to their means
  double time_products = 0;  // of time and capacitance, relative to their means
  std::size_t first = 0, last = 0;  // [first, last) of the readings
};

std::vector<Collected> collect(const RunView& view) {
  const RunData& data = view.data;
  std::vector<Collected> out(data.levels.size());
  for (std::size_t i = 0; i < data.readings.size(); ++i) {
    const RunReading& r = data.readings[i];
    if (!counts_in_level(view, r) || static_cast<std::size_t>(r.level) > out.size()) continue;
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

MeasuredLevel measured(const RunView& view, const LevelRow& row, const Collected& c,
                       double force_N) {
  MeasuredLevel l;
  l.level = row.level;
  l.repeat = row.repeat;
  l.index = row.index;
  l.t_s = c.time.mean;
  if (row.target_pressure_Pa) l.target_kPa = *row.target_pressure_Pa * 1e-3;
  l.pressure_kPa = *view.kPa(force_N);
  l.mean_pF = c.capacitance.mean * 1e12;
  l.first = c.first;
  l.last = c.last;
  l.readings = static_cast<std::int32_t>(c.capacitance.count);
  l.missing = std::max(0, row.planned_readings - l.readings);
  if (l.readings >= 2) {
    l.scatter_fF = std::sqrt(c.capacitance.variance()) * 1e15;
    l.standard_error_fF = *l.scatter_fF / std::sqrt(l.readings);
    const double kPa_per_N = *view.kPa(1);
    if (c.time.sum_squares > 0) {
      l.trend_ss_fF2 = c.time_products * c.time_products / c.time.sum_squares * 1e30;
    }
    l.covariance_fF_kPa = c.products / (l.readings - 1) * 1e15 * kPa_per_N;
    if (c.force.count >= 2) l.pressure_scatter_kPa = std::sqrt(c.force.variance()) * kPa_per_N;
  }
  return l;
}

// A level's direction is found by comparison with the level before it in the same repeat. The first
// level gets the direction of the second.
void find_directions(std::vector<MeasuredLevel>& levels) {
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

// Scatter of the levels between repeats when this part of the rests' deviations is subtracted.
std::optional<double> scatter_with(Drift drift, const MeasuredLevels& measured, double part) {
  drift.follow(part);
  std::vector<RangePoint> points;
  std::vector<LinePoint> line;
  for (const MeasuredLevel& l : measured.levels) {
    if (l.direction != measured.line_direction) continue;
    points.push_back(point_of(l, l.mean_pF * 1e3 - drift.at(l.t_s)));
    line.push_back(points.back().at);
  }
  const auto fit = fit_line(line);
  if (!fit) return std::nullopt;
  const auto error = error_between_repeats(points, fit->slope);
  return error ? std::optional(error->variance) : std::nullopt;
}

void measure(const RunView& view, const Rests& rests, MeasuredLevels& out) {
  const auto collected = collect(view);
  for (std::size_t i = 0; i < collected.size(); ++i) {
    const Collected& c = collected[i];
    const LevelRow& row = view.data.levels[i];
    if (c.capacitance.count == 0) continue;
    if (c.force.count == 0 && !row.target_force_N) continue;
    if (c.force.count == 0) ++out.without_force;
    const double force = c.force.count > 0 ? c.force.mean : *row.target_force_N;
    out.levels.push_back(measured(view, row, c, force));
  }
  find_directions(out.levels);
  const auto up = std::ranges::count(out.levels, Direction::up, &MeasuredLevel::direction);
  out.line_direction = 2 * up >= std::ssize(out.levels) ? Direction::up : Direction::down;
  find_outliers_of_levels(view, rests, out);
}

}  // namespace

LevelKey key_of(const MeasuredLevel& level) {
  const std::int64_t what =
      level.target_kPa ? std::llround(*level.target_kPa * 1e4) : std::int64_t{level.index};
  return {level.direction, what};
}

MeasuredLevels measure_levels(const RunView& view, const Rests& rests) {
  MeasuredLevels out;
  out.outliers.outliers = rests.outliers_of_rests;
  if (view.data.levels.empty()) {
    find_outliers_of_loadings(view, rests, out.outliers);
  } else if (view.data.area_m2) {
    measure(view, rests, out);
  }
  out.outliers.outlier_count = std::ssize(out.outliers.outliers);
  keep_largest_outliers(out.outliers.outliers);
  return out;
}

Scene::Scene(const RunView& view, const Rests& rests, const MeasuredLevels& measured)
    : RunView(view), Rests(rests) {
  const double part = drift.followed();
  if (part <= 0) return;
  const auto with = scatter_with(drift, measured, part), without = scatter_with(drift, measured, 0);
  if (with && without && *without < *with) drift.follow(0);
}

LevelResults calc_levels(const Scene& scene, const MeasuredLevels& measured, const Metric& c0) {
  LevelResults out{{}, measured.line_direction};
  for (const MeasuredLevel& m : measured.levels) {
    LevelResult& l = out.levels.emplace_back(m);
    l.drift_fF = scene.drift.at(l.t_s);
    l.capacitance_pF = l.mean_pF - l.drift_fF * 1e-3;
    if (c0) l.delta_C_fF = (l.capacitance_pF - c0.value()) * 1e3;
  }
  return out;
}

}  // namespace lcrig
