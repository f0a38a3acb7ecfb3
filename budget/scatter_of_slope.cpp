// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>

#include "analysis/even_slope.hpp"
#include "base/online.hpp"
#include "budget/loading_path.hpp"
#include "budget/scatter.hpp"

namespace lcrig {

namespace {

// Pairs of a loading's and an unloading's phase that are tried.
constexpr double kBranches = std::size(kPhases) * std::size(kPhases);

Scatter slope_of(const PlannedRun& run, double sxx, double sxy) {
  Scatter out;
  out.value = sxy / sxx;
  out.meter = run.reading_noise_F * 1e15 / std::sqrt(sxx);
  out.force = std::abs(out.value) * force_noise_kPa(run) / std::sqrt(sxx);
  return out;
}

std::optional<Scatter> slope_of_levels(const PlannedRun& run, const PressureRange& range) {
  RunningLine line, time;  // a level of n readings has weight n
  for (const PlannedLevel& l : run.levels) {
    if (!is_inside(range, l.pressure_kPa) || l.readings <= 0) continue;
    line.add(l.pressure_kPa, run.delta_C_fF(l.pressure_kPa), l.readings);
    time.add(l.pressure_kPa, l.t_s, l.readings);
  }
  if (!(line.sxx() > 1e-12 * line.weights() * line.x_mean() * line.x_mean())) return std::nullopt;
  Scatter out = slope_of(run, line.sxx(), line.sxy());
  out.drift = std::abs(time.slope()) * rate_error_fF_s(run);
  return out;
}

// The slope of one loading, and its uncertainty.
struct LoadingSlope {
  double slope = 0, sxx = 0;
  double variance = 0;  // of the slope, from where the readings fall
  double unit_variance_of_bend = 0;  // what the bend adds to it, for a reading of variance 1
};

// Pressures and capacitances of the readings of a branch that lie in the range, starting at the
// peak. A value that is found late is assigned a higher pressure. `phase`: of the delay.
std::vector<LinePoint> points_of(const PlannedRun& run, const PressureRange& range, double edge_kPa,
                                 const std::vector<double>& kPa, double phase) {
  std::vector<LinePoint> points;
  for (std::size_t i = 0; i < kPa.size() && kPa[i] > edge_kPa; ++i) {
    if (!is_inside(range, kPa[i])) continue;
    points.push_back({kPa[i], run.delta_C_fF(kPa[i]), 1});
    if (run.earlier_s <= 0) continue;
    const double before = i + 1 < kPa.size() ? run.delta_C_fF(kPa[i + 1]) : 0;
    const auto readings = static_cast<double>(kPa.size() - i);
    const double late_s = std::fmod(phase * run.earlier_s + readings * run.later_s, run.earlier_s);
    points.back().y -= (points.back().y - before) * late_s / run.interval_s;
  }
  return points;
}

LoadingSlope slope_of_loading(const PlannedRun& run, const PressureRange& range,
                              const PlannedCycle& c) {
  LoadingSlope out;
  out.slope = even_slope(run, range, c.peak_kPa);
  const double edge_kPa = kCycleEdge * c.peak_kPa;
  EvenSlopes slopes(std::max(range.from_kPa, edge_kPa), std::min(range.to_kPa, c.peak_kPa));
  const LoadingPath loading(run, c.peak_kPa, c.loading_s);
  for (const double nearest : kPhases) {
    const auto kPa = loading.kPa(loading.first_s(nearest));
    for (const double delay : kPhases) slopes.add(points_of(run, range, edge_kPa, kPa, delay));
  }
  RunningMean mean;
  for (const LineFit& l : slopes.lines()) {
    mean.add(l.slope);
    out.sxx += l.sxx / kBranches;
  }
  if (mean.count >= 2) out.variance = mean.variance();
  out.unit_variance_of_bend = slopes.unit_variance_of_bend() * kBranches;
  return out;
}

// Over the readings of the range: how much an error of one second would move the slope, and how
// much the time changes with pressure.
struct Tilt {
  double moved_per_s = 0, s_per_kPa = 0;
};
Tilt tilt_of(const PlannedRun& run, const PressureRange& range, const PlannedCycle& c) {
  const LoadingPath loading(run, c.peak_kPa, c.loading_s);
  const double nearest_s = loading.first_s(0.5);
  const auto kPa = loading.kPa(nearest_s);
  RunningLine moved, time;
  for (std::size_t i = 0; i < kPa.size() && kPa[i] > kCycleEdge * c.peak_kPa; ++i) {
    if (!is_inside(range, kPa[i])) continue;
    const double before_peak_s = nearest_s + static_cast<double>(i) * run.interval_s;
    const double step_kPa = 1e-3 * c.peak_kPa;
    const double slope =
        (run.delta_C_fF(kPa[i] + step_kPa) - run.delta_C_fF(kPa[i] - step_kPa)) / (2 * step_kPa);
    moved.add(kPa[i], slope * loading.rate_kPa_s(before_peak_s));
    time.add(kPa[i], -before_peak_s);
  }
  if (!(moved.sxx() > 0)) return {};
  return {moved.slope(), time.slope()};
}

std::optional<Scatter> slope_of_loadings(const PlannedRun& run, const PressureRange& range) {
  double sxx = 0, sxy = 0, by_chance = 0, bend = 0;
  LoadingSlope one;
  Tilt tilt;
  const PlannedCycle* before = nullptr;
  for (const PlannedCycle& c : run.cycles) {
    if (c.loading_s <= 0) continue;
    if (before == nullptr || !same_loading(*before, c)) {
      one = slope_of_loading(run, range, c);
      tilt = tilt_of(run, range, c);
    }
    before = &c;
    sxx += one.sxx;
    sxy += one.sxx * one.slope;
    by_chance += one.sxx * one.sxx * one.variance;
    bend += one.sxx * one.sxx * one.unit_variance_of_bend;
  }
  if (!(sxx > 0)) return std::nullopt;
  Scatter out = slope_of(run, sxx, sxy);
  out.instants = std::sqrt(by_chance) / sxx;
  // The bend that all loadings share comes from the same readings and has the same relative error.
  const double with_bend = std::sqrt(1 + bend / sxx);
  for (double* part : {&out.meter, &out.force, &out.instants}) *part *= with_bend;
  out.alignment = std::abs(tilt.moved_per_s) * instant_s(run);
  out.drift = std::abs(tilt.s_per_kPa) * rate_error_fF_s(run);
  return out;
}

}  // namespace

double even_slope(const PlannedRun& run, const PressureRange& range, double peak_kPa) {
  const double from = std::max(range.from_kPa, kCycleEdge * peak_kPa);
  const double to = std::min(range.to_kPa, peak_kPa);
  if (!(to > from)) return 0;
  RunningLine line;
  for (int i = 0; i <= 50; ++i) {
    const double kPa = from + i / 50.0 * (to - from);
    line.add(kPa, run.delta_C_fF(kPa));
  }
  return line.sxy() / line.sxx();
}

double rate_error_fF_s(const PlannedRun& run) {
  RunningLine line;
  for (const PlannedRest& r : run.rests) {
    if (r.readings >= static_cast<double>(kLeastOfRest)) line.add(r.t_s, 0, r.readings);
  }
  return line.sxx() > 0 ? run.reading_noise_F * 1e15 / std::sqrt(line.sxx()) : 0;
}

double window_s(const PlannedRun& run) {
  return run.meter.conversion_s.value_or(run.interval_s);
}

double instant_s(const PlannedRun& run) {
  return std::hypot(window_s(run), run.sample_s) / std::sqrt(12);
}

double force_noise_kPa(const PlannedRun& run) {
  return run.force_noise_N / run.area_m2 * 1e-3 * std::sqrt(kInterpolated);
}

std::optional<Scatter> scatter_of_slope(const PlannedRun& run, const PressureRange& range) {
  return run.levels.empty() ? slope_of_loadings(run, range) : slope_of_levels(run, range);
}

}  // namespace lcrig
