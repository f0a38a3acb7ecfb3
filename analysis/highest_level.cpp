// SPDX-License-Identifier: Apache-2.0
// The change of capacitance from C0 to the highest level.

#include "analysis/metrics.hpp"
#include "analysis/recovery.hpp"

namespace lcrig {

namespace {

// Scatter between repeats, or with one repeat that of its readings, widened for their correlation.
SlopePart scatter_of_level(const Scene& scene, const CurvePoint& level) {
  if (level.repeats > 1) return {*level.standard_error_fF, level.repeats - 1.0};
  const auto readings = static_cast<double>(level.readings);
  const Correlation& c = scene.correlation;
  return {*level.standard_error_fF * c.widening(),
          c.freedom > 0 ? c.degrees_of_freedom(readings - 1) : readings - 1};
}

SlopePart error_of_c0(const Estimate& c0) {
  return {*c0.standard_error * 1e3, c0.degrees_of_freedom.value_or(SlopePart().degrees_of_freedom)};
}

std::vector<double> times_of(const LevelResults& levels, const CurvePoint& level) {
  std::vector<double> out;
  for (const LevelResult& l : levels.levels) {
    if (l.direction == level.direction && l.pressure_kPa >= 0.99 * level.pressure_kPa) {
      out.push_back(l.t_s);
    }
  }
  return out;
}

// The drift is subtracted over the time from the first rest, where C0 is, to the level.
SlopePart error_of_drift(const Drift& drift, const std::vector<double>& times_s) {
  if (!drift.known()) return {};
  RunningMean since_s;
  for (const double t : times_s) since_s.add(t - drift.nodes().front().t_s);
  return {since_s.mean * drift.rate_se_fF_s() * (1 - drift.followed()), drift.rate_freedom()};
}

// Error from a specimen that has not recovered yet. This shifts all rests after a load against the
// baseline, which looks like drift. Its size is estimated as the difference to a drift whose rate
// comes from the rests after loads alone.
SlopePart recovery(const Scene& scene, const std::vector<double>& times_s) {
  const auto of_rests = drift_of_rests(scene);
  if (!of_rests) return {};
  RunningMean more_fF;
  for (const double t : times_s) more_fF.add(scene.drift.at(t) - of_rests->at(t));
  return {rectangular(more_fF.mean)};
}

}  // namespace

HighestLevelResult calc_highest_level(const Scene& scene, const LevelResults& levels,
                                      const CurveResult& curve, const Metric& c0) {
  HighestLevelResult out;
  out.delta_C = metric("delta_C_at_top", "fF",
                       "capacitance at the highest level less C0: mean of its repeats, drift "
                       "subtracted; standard error from the scatter between repeats, and from the "
                       "errors of C0 and of the drift, which all repeats share");
  const CurvePoint* top = nullptr;
  for (const CurvePoint& c : curve.curve) {
    if (c.direction != levels.line_direction) continue;
    if (top == nullptr || c.pressure_kPa > top->pressure_kPa) top = &c;
  }
  if (top == nullptr || !top->delta_C_fF) {
    out.delta_C.reason = top == nullptr ? "no level was measured" : "there is no C0";
    return out;
  }
  out.top_kPa = top->pressure_kPa;
  out.delta_C.rows = top->readings;
  out.delta_C.estimand = name_estimand(scene, levels, *top);
  out.delta_C.estimate = Estimate(*top->delta_C_fF);
  if (!top->standard_error_fF || !c0.estimate->standard_error) {
    out.delta_C.reason = "one reading: no scatter";
    return out;
  }
  const auto times_s = times_of(levels, *top);
  out.parts_of_delta_C = {scatter_of_level(scene, *top), error_of_c0(*c0.estimate),
                          error_of_drift(scene.drift, times_s), recovery(scene, times_s)};
  out.delta_C.estimate =
      estimate_of_parts(*top->delta_C_fF, out.parts_of_delta_C, scene.options.confidence);
  if (top->repeats == 1) out.delta_C.reason = kOneRepeat;
  return out;
}

}  // namespace lcrig
