// SPDX-License-Identifier: Apache-2.0
// The `measure` steps: mean, scatter, outliers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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

}  // namespace lcrig
