// SPDX-License-Identifier: Apache-2.0
// Collects the `measure` steps: mean, scatter and outliers of each level.
#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/replicates.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kListedOutliers = 1000;
// Share of runs without outliers in which one is found by mistake. It sets the limit for outliers.
constexpr double kFalseOutliers = 0.01;

struct Collected {
  RunningMean capacitance, time, force;
  double products = 0;  // of force and capacitance, relative to their means
  double time_products = 0;  // of time and capacitance, relative to their means
  std::size_t first = 0, last = 0;  // [first, last) of the readings
};

bool counts(const RunView& view, const RunReading& r) {
  return r.index > 0 && r.level > 0 && view.uses(r) && (r.has_force() || !view.data.has_frame());
}

std::vector<Collected> collect(const RunView& view) {
  const RunData& data = view.data;
  std::vector<Collected> out(data.levels.size());
  for (std::size_t i = 0; i < data.readings.size(); ++i) {
    const RunReading& r = data.readings[i];
    if (!counts(view, r) || static_cast<std::size_t>(r.level) > out.size()) continue;
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

// Corrects the robust standard deviation of few readings. Readings lie nearer to the median of
// their own few than to the true middle. The factor is their standard deviation over 1.4826 times
// the median of their distances. It comes from 400,000 sets of normal numbers for each size; from
// ten readings on the formula holds within 1.2 %.
double robust_sigma_factor(std::int32_t readings) {
  constexpr std::array kOfFew = {1.390, 1.375, 1.277, 1.223, 1.197, 1.158};  // for 4 to 9 readings
  const auto k = static_cast<std::size_t>(readings - 4);
  return k < kOfFew.size() ? kOfFew[k] : readings / (readings - 1.3);
}

// Factor on `limit_of_outliers` for `all` readings, `each` in a level: the farthest one exceeds the
// product in one run of a hundred. The median of few may be off, and their scatter is badly known.
// From 1500 to 20,000 runs of normal numbers for 4 to 50 readings of 3 to 80 levels; within 5 %.
double limit_of_few(double all, double each) {
  return 1 + (0.7 + 4 / each) / std::sqrt(all) + (2 + 33 / each) / all;
}

// Compares every reading with the median of its level, in pooled robust standard deviations.
void find_outliers(const RunView& view, MeasuredLevels& out) {
  const auto& readings = view.data.readings;
  std::vector<double> medians(out.levels.size()), all, values;
  double judged = 0;  // number of levels with enough readings
  for (std::size_t k = 0; k < medians.size(); ++k) {
    const MeasuredLevel& l = out.levels[k];
    if (l.readings < 4) continue;
    values.clear();
    for (std::size_t i = l.first; i < l.last; ++i) {
      if (counts(view, readings[i])) values.push_back(readings[i].capacitance_F);
    }
    medians[k] = median(values);
    const double factor = robust_sigma_factor(l.readings);
    for (const double v : values) all.push_back(factor * (v - medians[k]));
    judged += 1;
  }
  const double sigma = robust_sigma(all);
  if (sigma <= 0) return;
  const auto count = static_cast<double>(all.size());
  const double limit = limit_of_outliers(all.size()) * limit_of_few(count, count / judged);
  for (std::size_t k = 0; k < medians.size(); ++k) {
    MeasuredLevel& l = out.levels[k];
    for (std::size_t i = l.first; i < l.last && l.readings >= 4; ++i) {
      Outlier found = outlier_of(readings[i], medians[k], sigma);
      if (!counts(view, readings[i]) || std::abs(found.deviations) <= limit) continue;
      found.level = l.level;
      found.index = readings[i].index;
      ++l.outliers;
      out.outliers.outliers.push_back(found);
    }
  }
}

std::vector<std::size_t> used_in(const RunView& view, const Loading& c) {
  std::vector<std::size_t> out;
  for (std::size_t i = c.first; i < c.last; ++i) {
    if (view.uses(view.data.readings[i])) out.push_back(i);
  }
  return out;
}

// Noise of one reading during a loading, from second differences, in which an even loading cancels.
double noise_of_loadings(const RunView& view, const Rests& rests) {
  std::vector<double> bends;
  for (const RestedLoading& c : rests.loadings) {
    const auto used = used_in(view, c);
    for (std::size_t k = 1; k + 1 < used.size(); ++k) {
      const auto at = [&](std::size_t i) { return view.data.readings[used[i]].capacitance_F; };
      bends.push_back(at(k - 1) - 2 * at(k) + at(k + 1));
    }
  }
  return robust_sigma(bends) / std::sqrt(6.0);
}

// Finds readings far from the median of their neighbours in a loading. Such a reading is off by
// `limit` standard deviations, and by more than five times the spread of its neighbours. A turn of
// the force or a bend of the curve does not do that.
void find_outliers_of_loading(const RunView& view, const Loading& c, double sigma, double limit,
                              std::vector<Outlier>& out) {
  constexpr std::size_t kWindow = 7, kMost = 5;  // kMost: the closest together, whose spread counts
  constexpr double kStandsOut = 5;
  const auto used = used_in(view, c);
  if (used.size() < kWindow) return;
  for (std::size_t k = 0; k < used.size(); ++k) {
    const std::size_t begin = std::min(k - std::min(k, kWindow / 2), used.size() - kWindow);
    std::array<double, kWindow> near{};
    for (std::size_t i = 0; i < kWindow; ++i) {
      near[i] = view.data.readings[used[begin + i]].capacitance_F;
    }
    std::ranges::sort(near);
    double spread = near[kMost - 1] - near[0];
    for (std::size_t i = 1; i + kMost <= kWindow; ++i) {
      spread = std::min(spread, near[i + kMost - 1] - near[i]);
    }
    const RunReading& r = view.data.readings[used[k]];
    const double off = std::abs(r.capacitance_F - near[kWindow / 2]);
    if (off > limit * sigma && off > kStandsOut * spread) {
      out.push_back(outlier_of(r, near[kWindow / 2], sigma));
    }
  }
}

void find_outliers_of_loadings(const RunView& view, const Rests& rests, Outliers& out) {
  const double sigma = noise_of_loadings(view, rests);
  if (sigma <= 0) return;
  const double limit = limit_of_outliers(view.data.readings.size());
  for (const RestedLoading& c : rests.loadings) {
    find_outliers_of_loading(view, c, sigma, limit, out.outliers);
  }
}

void keep_largest_outliers(std::vector<Outlier>& outliers) {
  std::sort(outliers.begin(), outliers.end(), [](const Outlier& a, const Outlier& b) {
    return std::abs(a.deviations) > std::abs(b.deviations);
  });
  if (outliers.size() > kListedOutliers) outliers.resize(kListedOutliers);
}

void measure(const RunView& view, MeasuredLevels& out) {
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
  find_outliers(view, out);
}

}  // namespace

double limit_of_outliers(std::size_t readings) {
  const double tail = kFalseOutliers / (2 * static_cast<double>(readings));
  return std::max(3.5, -normal_quantile(tail));
}

Outlier outlier_of(const RunReading& r, double middle_F, double sigma_F) {
  const double off = r.capacitance_F - middle_F;
  return {r.t_s, 0, 0, r.capacitance_F * 1e12, off * 1e15, off / sigma_F};
}

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
    measure(view, out);
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
