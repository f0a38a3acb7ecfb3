// SPDX-License-Identifier: Apache-2.0
// Sensitivity of a run without levels: from the readings of the loading branches.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/even_slope.hpp"
#include "analysis/moved_slope.hpp"
#include "analysis/replicates.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr const char* kOfCycles =
    "slope of C against pressure: least squares over the readings of the loading branches in the "
    "range, one level for each cycle and one bend for all, by which it is the slope of pressures "
    "evenly over the range; the interval from the scatter between cycles and from the drift that "
    "is "
    "subtracted";

// Readings of one loading branch.
struct Branch {
  std::vector<LinePoint> points;
  std::vector<LinePoint> rates, times;  // y: rate in kPa/s and time in s, against pressure
  double instant_s = 0;
};
Branch branch(const Scene& scene, const CycleResult& c, const PressureRange& range,
              Moving& moving) {
  Branch b;
  const double rest_fF = c.rest_pF * 1e3 - scene.drift.at(c.rest_s);
  for (std::size_t i = c.first; i < c.last; ++i) {
    const RunReading& r = scene.data.readings[i];
    if (!moving(i) || r.t_s > c.peak_s || spans_turn(c, r)) continue;
    const double kPa = *scene.kPa(scene.above_rest_N(r));
    if (!is_inside(range, kPa)) continue;
    b.points.push_back({kPa, scene.fF(r) - rest_fF, 1});
    b.rates.push_back({kPa, *scene.kPa(r.force_rate_N_s), 1});
    b.times.push_back({kPa, r.t_s, 1});
    b.instant_s = std::max(b.instant_s, static_cast<double>(r.alignment_s));
  }
  return b;
}

struct CycleBranches {
  std::vector<LineFit> lines;
  double sxx = 0, sxy = 0, syy = 0, residual_ss = 0, weight = 0, x = 0, y = 0;
  double rate_sxy = 0, time_sxy = 0, instant_s = 0, moved_per_s = 0;
  RunningMean s_per_kPa;  // how long the load takes for a step of the pressure
  double unit_variance_of_bend = 0;
};

double mean_peak_kPa(const SlopeBasis& basis) {
  RunningMean peak_kPa;
  for (const CycleResult& c : basis.cycles.cycles) peak_kPa.add(c.peak_kPa.value_or(0));
  return peak_kPa.mean;
}

// The part of the range that the cycles reach.
PressureRange reached(const SlopeBasis& basis, const PressureRange& range) {
  const double peak_kPa = mean_peak_kPa(basis);
  return {std::max(range.from_kPa, kCycleEdge * peak_kPa), std::min(range.to_kPa, peak_kPa)};
}

// Completes the estimand: which part of the range the loadings cover.
std::string reach_of(const SlopeBasis& basis, const PressureRange& range) {
  const double peak_kPa = mean_peak_kPa(basis);
  std::string out;
  const double edge_kPa = kCycleEdge * peak_kPa;
  if (edge_kPa > range.from_kPa) {
    out += fmt::format(", from {:.3g} kPa ({:g} % of the largest force) on", edge_kPa,
                       kCycleEdge * 100);
  }
  if (peak_kPa < range.to_kPa) out += fmt::format(", up to the peak of {:.3g} kPa", peak_kPa);
  return out;
}

CycleBranches fit_branches(const SlopeBasis& basis, const PressureRange& range) {
  CycleBranches b;
  const PressureRange covered = reached(basis, range);
  EvenSlopes slopes(covered.from_kPa, covered.to_kPa);
  MovedSlope moved;
  Moving moving(basis.scene, basis.holds);
  for (const CycleResult& c : basis.cycles.cycles) {
    const Branch readings = branch(basis.scene, c, range, moving);
    if (!slopes.add(readings.points)) continue;
    b.rate_sxy += fit_line(readings.rates)->sxy;
    b.time_sxy += fit_line(readings.times)->sxy;
    b.instant_s = std::max(b.instant_s, readings.instant_s);
    b.s_per_kPa.add(fit_line(readings.times)->slope);
    moved.begin_group();
    for (std::size_t i = 0; i < readings.points.size(); ++i) {
      moved.add(readings.points[i].x, readings.points[i].y, readings.rates[i].y);
    }
  }
  b.moved_per_s = moved.per_s();
  b.lines = slopes.lines();
  b.unit_variance_of_bend = slopes.unit_variance_of_bend();
  for (const LineFit& l : b.lines) {
    b.sxx += l.sxx;
    b.sxy += l.sxx * l.slope;
    b.syy += l.syy;
    b.weight += l.sum_weights;
    b.x += l.sum_weights * l.x_mean;
    b.y += l.sum_weights * l.y_mean;
  }
  const double slope = b.sxy / b.sxx;
  for (const LineFit& l : b.lines) {
    b.residual_ss += l.residual_ss + l.sxx * (l.slope - slope) * (l.slope - slope);
  }
  return b;
}

// Error of a slope that all cycles share, while each cycle has its own level. With several cycles
// it is the scatter of their slopes, which does not depend on the shape of the curve. With one
// cycle it is the scatter about its line, corrected for the correlation of neighbouring readings.
PureError branch_error(const Scene& scene, const CycleBranches& b, double slope) {
  const auto cycles = static_cast<double>(b.lines.size());
  if (cycles >= 2) {
    double ss = 0;
    for (const LineFit& l : b.lines) ss += l.sxx * (l.slope - slope) * (l.slope - slope);
    return {ss / (cycles - 1), cycles - 1,
            fmt::format("scatter of the slopes of {} cycles", b.lines.size())};
  }
  const double freedom = b.weight - cycles - 1, rho = scene.correlation.rho;
  return {b.residual_ss / freedom * (1 + rho) / (1 - rho),
          scene.correlation.freedom > 0 ? scene.correlation.degrees_of_freedom(freedom) : freedom,
          "scatter about the line of one cycle, the curve's own shape included"};
}

}  // namespace

RangeResult slope_of_cycles(const SlopeBasis& basis, const PressureRange& range) {
  RangeResult r;
  r.range = range;
  r.sensitivity = metric("sensitivity", "fF/kPa", kOfCycles);
  const CycleBranches b = fit_branches(basis, range);
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
  const PureError error = branch_error(basis.scene, b, slope);
  r.parts_of_error = {{std::sqrt(error.variance * (1 / b.sxx + b.unit_variance_of_bend)),
                       error.degrees_of_freedom}};
  // The subtracted drift has the same error in all loadings, so their scatter does not show it.
  const Drift& drift = basis.scene.drift;
  if (drift.known()) {
    r.parts_of_error.push_back(
        {std::abs(b.time_sxy / b.sxx) * drift.rate_se_fF_s(), drift.rate_freedom()});
  }
  r.sensitivity.estimate =
      estimate_of_parts(slope, r.parts_of_error, basis.scene.options.confidence);
  if (b.lines.size() == 1) add_remark(r.sensitivity.reason, kOneCycle);
  add_remark(r.sensitivity.reason, basis.cycles.why_left_out);
  r.scatter_basis = error.basis;
  if (b.syy > 0) r.r_squared = std::max(0.0, 1 - b.residual_ss / b.syy);
  r.residual_fF = std::sqrt(b.residual_ss / b.weight);
  r.mean_kPa = b.x / b.weight;
  r.mean_delta_C_fF = b.y / b.weight;
  r.intercept_fF = *r.mean_delta_C_fF - slope * *r.mean_kPa;
  for (const LineFit& l : b.lines) r.slope_of_repeat.push_back(l.slope);
  r.rate_tilt_per_s = b.rate_sxy / b.sxx;
  r.instant_s = b.instant_s;
  r.moved_per_s = b.moved_per_s;
  r.residual_pattern = "continuous loading: see the loops";
  name_estimand(basis.scene, basis.levels, range, r.sensitivity);
  r.sensitivity.estimand += reach_of(basis, range);
  const PressureRange covered = reached(basis, range);
  LoadState& load = *r.sensitivity.load;
  load.from_kPa = covered.from_kPa;
  load.to_kPa = covered.to_kPa;
  if (b.s_per_kPa.mean > 0) {
    load.log10_s = std::log10(b.s_per_kPa.mean * (covered.to_kPa - covered.from_kPa));
  }
  return r;
}

}  // namespace lcrig
