// SPDX-License-Identifier: Apache-2.0
// The parts of the uncertainty of each result: its scatter, and the errors that all readings share.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/metrics.hpp"
#include "analysis/moved_slope.hpp"

namespace lcrig {

UncertaintyPart part(std::string name, double u, std::string basis) {
  UncertaintyPart p;
  p.name = std::move(name);
  p.standard_uncertainty = std::abs(u);
  p.basis = std::move(basis);
  return p;
}

UncertaintyPart of(ErrorSource source, UncertaintyPart p) {
  p.source = source;
  return p;
}

RigErrors rig_errors_of(const RunView& view, double capacitance_pF) {
  RigRecord record;
  if (view.setting_known) record.setting = view.setting;
  record.probe_diameter_m = view.data.probe_diameter_m;
  record.pressure = view.data.pressure;
  record.dead_weights = view.data.dead_weights;
  record.force_class_percent = view.data.force_class_percent;
  record.corrections = view.data.corrections;
  record.at_unix_ns = view.data.row.started_unix_ns;
  return rig_errors(record, view.options.rig, capacitance_pF * 1e-12);
}

namespace {

UncertaintyPart type_a(std::string name, const SlopePart& of, std::string basis) {
  UncertaintyPart p = part(std::move(name), of.se, std::move(basis));
  p.kind = UncertaintyKind::a;
  p.degrees_of_freedom = of.degrees_of_freedom;
  return p;
}

double half_width(const Metric& m) {
  const auto& interval = m.estimate->interval;
  return interval ? ((*interval)[1] - (*interval)[0]) / 2 : 0;
}

// Starts the uncertainty of a result that has a value; it has no parts yet.
Uncertainty begin(const Metric& m, std::string quantity, std::string unit, UncertainResult result) {
  Uncertainty b;
  b.result = result;
  b.quantity = std::move(quantity);
  b.unit = std::move(unit);
  b.estimand = m.estimand;
  b.value = m.value();
  b.least = half_width(m);
  return b;
}

void finish(const Scene& scene, Uncertainty& b, std::vector<Uncertainty>& list) {
  combine(b, scene.options.confidence);
  list.push_back(std::move(b));
}

UncertaintyPart scatter(const SlopePart& of, const std::string& basis) {
  UncertaintyPart p = type_a("scatter", of, basis);
  p.shrinks = true;
  return p;
}
UncertaintyPart scatter(const Estimate& e, const std::string& basis) {
  return scatter(
      SlopePart{*e.standard_error, e.degrees_of_freedom.value_or(SlopePart().degrees_of_freedom)},
      basis);
}

void add_meter_gain(const RigErrors& rig, double value, Uncertainty& b) {
  for (UncertaintyPart& p : parts_of_meter_gain(rig, value)) b.parts.push_back(std::move(p));
}

void add_open_correction(const RigErrors& rig, double per_F, Uncertainty& b) {
  b.parts.push_back(part_of_open_correction(rig, per_F));
}

void add_pressure(const RigErrors& rig, double per_relative, Uncertainty& b) {
  b.parts.push_back(part_of("force", rig.force, per_relative));
  b.parts.push_back(part_of(name_of_area(rig), rig.area, per_relative));
}

// Adds the error that is left after the drift was subtracted. `left` is 0 if the scatter has it.
void add_drift_part(const Metric& drift, const SlopePart& left, Uncertainty& b) {
  if (!drift.estimate) {
    b.parts.push_back(gap("drift of C0", "not known: no rests to tell it by"));
    return;
  }
  b.parts.push_back(type_a(
      "drift of C0", left,
      fmt::format("{:.3g} fF/h between the rests, subtracted; what their own scatter leaves{}",
                  drift.value(), left.se > 0 ? "" : " is within the scatter")));
}

void add_shared(const RangeResult& r, Uncertainty& b) {
  if (!r.shared) {
    b.parts.push_back(gap("scatter that repeats share",
                          "not known: it takes six levels to tell it from the curve's shape"));
    return;
  }
  b.parts.push_back(type_a(
      "scatter that repeats share", *r.shared,
      "deviations of the levels from a cubic through all of them, beyond the scatter between "
      "repeats: seating, probe, electrode, and the shape that a cubic does not have"));
}

// An error of the instant that all readings share moves each pressure in proportion to its rate.
void add_alignment(const SlopeBasis& basis, const RangeResult& r, Uncertainty& b) {
  const Scene& scene = basis.scene;
  std::vector<RunningMean> rate(scene.data.levels.size() + 1);
  std::vector<double> time(rate.size());
  for (const RunReading& x : scene.data.readings) {
    if (x.index <= 0 || static_cast<std::size_t>(x.level) >= rate.size()) continue;
    const auto k = static_cast<std::size_t>(x.level);
    rate[k].add(x.force_rate_N_s);
    time[k] = std::max(time[k], static_cast<double>(x.alignment_s));
  }
  const double area_m2 = scene.data.area_m2.value_or(1);
  double u_s = 0;
  MovedSlope moved;
  std::int32_t repeat = -1;
  for (const LevelResult& l : basis.levels.levels) {
    const double kPa = l.target_kPa.value_or(l.pressure_kPa);
    if (l.direction != basis.levels.line_direction || !is_inside(r.range, kPa)) continue;
    if (l.repeat != repeat) moved.begin_group();
    repeat = l.repeat;
    const auto k = static_cast<std::size_t>(l.level);
    u_s = std::max(u_s, time[k]);
    moved.add(l.pressure_kPa, l.capacitance_pF * 1e3, rate[k].mean / area_m2 * 1e-3);
  }
  b.parts.push_back(part("alignment of the clocks", moved.per_s() * u_s,
                         fmt::format("instant of a reading +-{:.3g} ms (window and spacing of the "
                                     "frame's samples), rate of force at the levels",
                                     u_s * 1e3)));
}

// The same for a loading, where the rate grows as the specimen stiffens and the curve bends.
void add_alignment_of_cycles(const RangeResult& r, Uncertainty& b) {
  b.parts.push_back(
      part("alignment of the clocks", r.moved_per_s * r.instant_s,
           fmt::format("instant of a reading +-{:.3g} ms (window and spacing of the frame's "
                       "samples); it moves the slope by {:.3g} fF/kPa a second: the rate of "
                       "pressure changes by {:.3g} kPa/s per kPa, and the curve bends",
                       r.instant_s * 1e3, r.moved_per_s, r.rate_tilt_per_s)));
}

// Change of the force sensitivity per second of error of the instant, fF/N per second.
double moved_force_sensitivity_per_s(const SlopeBasis& basis) {
  const Scene& scene = basis.scene;
  MovedSlope moved;
  Moving moving(scene, basis.holds);
  for (const CycleResult& c : basis.cycles.cycles) {
    moved.begin_group();
    for (std::size_t i = c.first; i < c.last; ++i) {
      const RunReading& r = scene.data.readings[i];
      if (!moving(i) || r.t_s > c.peak_s || spans_turn(c, r)) continue;
      moved.add(scene.above_rest_N(r), scene.fF(r), r.force_rate_N_s);
    }
  }
  return moved.per_s();
}

void uncertainty_of_c0(const Scene& scene, const BaselineResult& out,
                       std::vector<Uncertainty>& list) {
  if (!out.c0 || !out.c0.estimate->standard_error) return;
  Uncertainty b = begin(out.c0, "C0", "pF", UncertainResult::c0);
  b.parts.push_back(scatter(*out.c0.estimate, out.c0_basis));
  const RigErrors rig = rig_errors_of(scene, b.value);
  b.parts.push_back(part_of("meter specification", rig.meter_total, 1e12));
  add_open_correction(rig, 1e12, b);
  if (!rig.short_correction.limit)
    b.parts.push_back(part_of("short correction", rig.short_correction, b.value));
  if (!rig.leads.limit) b.parts.push_back(part_of("leads", rig.leads, b.value));
  if (out.drift_of_baseline_fF) {
    b.parts.push_back(part("drift during the run", rectangular(*out.drift_of_baseline_fF * 1e-3),
                           "last stretch without load against the first, rectangular"));
  }
  finish(scene, b, list);
}

// Error of the peaks from windows that include the turn. The mean force of such a window is less
// than the force in its middle: by rate x window / 4 if the turn is in the middle, and by a third
// of that on average over all places of the turn. Percent of C0.
double turn_percent(const Scene& scene, const std::vector<CycleResult>& cycles, double c0_pF) {
  double sum_fF = 0;
  for (const CycleResult& c : cycles) {
    if (c.peak_method != PeakMethod::fit || !c.slope_fF_per_N) continue;
    double rate_N_s = 0, window_s = 0;
    for (std::size_t i = c.first; i < c.last; ++i) {
      const RunReading& r = scene.data.readings[i];
      window_s = std::max(window_s, 2 * r.half_window_s());
      if (r.has_force() && !spans_turn(c, r) && scene.above_rest_N(r) > c.peak_force_N / 2) {
        rate_N_s = std::max(rate_N_s, static_cast<double>(std::abs(r.force_rate_N_s)));
      }
    }
    sum_fF += *c.slope_fF_per_N * rate_N_s * window_s / 12;
  }
  return sum_fF / static_cast<double>(cycles.size()) / (c0_pF * 1e3) * 100;
}

void uncertainty_of_dynamic_range(const SlopeBasis& basis, std::vector<Uncertainty>& list) {
  const Scene& scene = basis.scene;
  const CycleResults& out = basis.cycles;
  if (!out.dynamic_range || !out.dynamic_range.estimate->standard_error) return;
  Uncertainty b = begin(out.dynamic_range, "dynamic range", "%", UncertainResult::dynamic_range);
  const bool several = out.cycles.size() > 1;
  b.parts.push_back(scatter(out.parts_of_dynamic_range.front(),
                            several ? "scatter between cycles" : "scatter of the readings"));
  const double c0_pF = basis.baseline.c0.value();
  const RigErrors rig = rig_errors_of(scene, c0_pF);
  const double per_F = b.value / (c0_pF * 1e-12);
  UncertaintyPart offset = part_of("meter offset in C0", rig.meter_offset, per_F);
  offset.basis += "; the meter's gain cancels";
  b.parts.push_back(std::move(offset));
  add_open_correction(rig, per_F, b);
  double peak_N = 0;
  for (const CycleResult& c : out.cycles) peak_N += c.peak_force_N;
  const double percent = slope_at_peak_fF_per_N(scene, out.cycles) * peak_N /
                         static_cast<double>(out.cycles.size()) / (c0_pF * 1e3) * 100;
  add_pressure(rig, percent, b);
  for (const std::size_t i : {b.parts.size() - 2, b.parts.size() - 1}) {
    b.parts[i].basis += ", times the slope of the curve at the peak";
  }
  b.parts[b.parts.size() - 2].name = "force at the peak";
  const auto& common = out.parts_of_dynamic_range;
  add_drift_part(basis.baseline.drift, common.size() > 1 ? common[1] : SlopePart(), b);
  if (common.size() > 2) {
    b.parts.push_back(part("recovery at the rests", common[2].se,
                           "what of the drift is, or may be, a specimen that recovers from its "
                           "loads: limits, rectangular"));
  }
  add_other_choices_of_dynamic_range(basis, b);
  if (const double turn = turn_percent(scene, out.cycles, c0_pF); turn > 0) {
    b.parts.push_back(part("turn within a window", turn,
                           "the meter's mean over a window that reaches over the peak: a twelfth "
                           "of rate times window less, in the mean"));
  }
  finish(scene, b, list);
}

// Slope against pressure at the highest level. It is the slope at the peaks, or that of the curve's
// upper half when the force is not known. It does not depend on the requested ranges.
double slope_at_top(const Scene& scene, const std::vector<CycleResult>& cycles, Direction direction,
                    const std::vector<CurvePoint>& curve, const HighestLevelResult& top) {
  if (!cycles.empty() && scene.data.area_m2) {
    return slope_at_peak_fF_per_N(scene, cycles) * *scene.data.area_m2 * 1e3;
  }
  std::vector<LinePoint> points;
  for (const CurvePoint& c : curve) {
    if (c.direction == direction && 2 * c.pressure_kPa >= top.top_kPa) {
      points.push_back({c.pressure_kPa, c.capacitance_pF * 1e3, 1});
    }
  }
  const auto line = fit_line(points);
  return line ? line->slope : top.delta_C.value() / top.top_kPa;
}

void uncertainty_of_highest_level(const SlopeBasis& basis, std::vector<Uncertainty>& list) {
  const Scene& scene = basis.scene;
  const HighestLevelResult& top = basis.highest;
  if (top.parts_of_delta_C.empty()) return;
  Uncertainty b = begin(top.delta_C, fmt::format("delta C at {:.4g} kPa", top.top_kPa), "fF",
                        UncertainResult::delta_C);
  b.parts.push_back(scatter(top.parts_of_delta_C[0], "between repeats; of one, of its readings"));
  b.parts.push_back(scatter(top.parts_of_delta_C[1], "of the baseline; all levels share it"));
  b.parts.back().name = "C0";
  const RigErrors rig = rig_errors_of(scene, basis.baseline.c0.value());
  add_meter_gain(rig, b.value, b);
  const double change = slope_at_top(scene, basis.cycles.cycles, basis.levels.line_direction,
                                     basis.curve.curve, top) *
                        top.top_kPa;
  add_pressure(rig, change, b);
  add_drift_part(basis.baseline.drift, top.parts_of_delta_C[2], b);
  b.parts.push_back(part("recovery at the rests", top.parts_of_delta_C[3].se,
                         "what of the drift may be a specimen that has not recovered yet: limits, "
                         "rectangular"));
  add_other_choices_of_highest_level(basis, b);
  finish(scene, b, list);
}

void uncertainty_of_force_sensitivity(const SlopeBasis& basis, std::vector<Uncertainty>& list) {
  const Scene& scene = basis.scene;
  const CycleResults& out = basis.cycles;
  if (out.parts_of_force_sensitivity.empty()) return;
  Uncertainty b =
      begin(out.force_sensitivity, "force sensitivity", "fF/N", UncertainResult::force_sensitivity);
  b.parts.push_back(scatter(
      out.parts_of_force_sensitivity.front(),
      out.cycles.size() > 1 ? "scatter between cycles" : "scatter about the line of one cycle"));
  const RigErrors rig = rig_errors_of(scene, basis.baseline.c0 ? basis.baseline.c0.value() : 0);
  add_meter_gain(rig, b.value, b);
  b.parts.push_back(part_of("force", rig.force, b.value));
  b.parts.push_back(part("alignment of the clocks",
                         moved_force_sensitivity_per_s(basis) * out.instant_s,
                         fmt::format("instant of a reading +-{:.3g} ms; the rate of force changes "
                                     "by {:.3g} N/s per N, and the curve bends",
                                     out.instant_s * 1e3, out.force_rate_tilt_per_s)));
  add_drift_part(
      basis.baseline.drift,
      out.parts_of_force_sensitivity.size() > 1 ? out.parts_of_force_sensitivity[1] : SlopePart(),
      b);
  add_other_choices_of_force_sensitivity(basis, b);
  finish(scene, b, list);
}

void uncertainty_of_hysteresis(const Scene& scene, const Hysteresis& h,
                               std::vector<Uncertainty>& list) {
  if (!h.largest_gap || !h.largest_gap.estimate->standard_error) return;
  Uncertainty b = begin(h.largest_gap, "hysteresis", "%", UncertainResult::hysteresis);
  b.parts.push_back(scatter(*h.largest_gap.estimate, h.basis));
  b.parts.push_back(part("alignment of the clocks", h.alignment_percent.value_or(0),
                         "one error of the instant shifts loading and unloading apart"));
  finish(scene, b, list);
}

}  // namespace

Uncertainty uncertainty_of(const SlopeBasis& basis, const RangeResult& r) {
  const Scene& scene = basis.scene;
  const auto& levels = basis.levels.levels;
  const Metric& c0 = basis.baseline.c0;
  Uncertainty b;
  b.quantity = fmt::format("sensitivity {}", range_text(r.range));
  b.unit = "fF/kPa";
  b.estimand = r.sensitivity.estimand;
  if (!r.sensitivity.estimate) return b;
  const double slope = r.sensitivity.value();
  b.value = slope;
  if (r.sensitivity.estimate->standard_error) {
    b.parts.push_back(scatter(r.parts_of_error.front(), r.scatter_basis));
  }
  const double pF = c0 ? c0.value() : levels.empty() ? 0 : levels[0].capacitance_pF;
  const RigErrors rig = rig_errors_of(scene, pF);
  add_meter_gain(rig, slope, b);
  UncertaintyPart offset = part_of("meter offset", rig.meter_offset, 0);
  offset.basis += ": cancels in a slope, as an open correction does";
  if (rig.meter_offset.limit) b.parts.push_back(std::move(offset));
  add_pressure(rig, slope, b);
  if (!levels.empty()) {
    add_alignment(basis, r, b);
  } else {
    add_alignment_of_cycles(r, b);
  }
  add_drift_part(
      basis.baseline.drift,
      r.parts_of_error.size() > 1 && r.parts_of_error[1].se > 0 ? r.parts_of_error[1] : SlopePart(),
      b);
  if (!levels.empty()) add_shared(r, b);
  add_other_choices(basis, r, b);
  b.least = half_width(r.sensitivity);
  combine(b, scene.options.confidence);
  return b;
}

std::vector<Uncertainty> calc_uncertainties(const SlopeBasis& basis,
                                            const SensitivityResult& sensitivity) {
  std::vector<Uncertainty> list;
  for (const RangeResult& r : sensitivity.ranges) {
    if (!r.uncertainty.parts.empty()) list.push_back(r.uncertainty);
  }
  uncertainty_of_c0(basis.scene, basis.baseline, list);
  uncertainty_of_dynamic_range(basis, list);
  uncertainty_of_force_sensitivity(basis, list);
  uncertainty_of_highest_level(basis, list);
  uncertainty_of_hysteresis(basis.scene, basis.hysteresis, list);
  return list;
}

}  // namespace lcrig
