// SPDX-License-Identifier: Apache-2.0
// Writes the JSON of `lcrig analyze`: metrics under the names of the design, and all other results.
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/analysis_text.hpp"
#include "analysis/metrics.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

json number(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}
template <class T>
json number(const std::optional<T>& value) {
  return value ? number(static_cast<double>(*value)) : json(nullptr);
}
json pair(const std::optional<std::array<double, 2>>& v) {
  return v ? json::array({number((*v)[0]), number((*v)[1])}) : json(nullptr);
}

json value_of(const Metric& m) {
  return m ? number(m.value()) : json(nullptr);
}
json error_of(const Metric& m) {
  return m ? number(m.estimate->standard_error) : json(nullptr);
}

constexpr double kOfCi95 = 0.95;  // "ci95" is always 95 %, whatever confidence was asked for

json ci95(const Metric& m) {
  if (!m || !m.estimate->standard_error || !m.estimate->degrees_of_freedom) return nullptr;
  const Estimate& e = *m.estimate;
  if (e.is_deviation) {
    return pair(estimate_of_deviation(e.value, *e.degrees_of_freedom, kOfCi95).interval);
  }
  return pair(estimate(e.value, *e.standard_error, *e.degrees_of_freedom, kOfCi95).interval);
}

json of(const Metric& m) {
  json j = {{"value", value_of(m)},   {"standard_error", error_of(m)},
            {"ci95", ci95(m)},        {"degrees_of_freedom", nullptr},
            {"readings", m.rows},     {"definition", m.definition},
            {"estimand", m.estimand}, {"remark", m.reason}};
  if (m) j["degrees_of_freedom"] = number(m.estimate->degrees_of_freedom);
  return j;
}

json of(const RangeResult& r, const PressureArea& pressure) {
  const auto on_disc = pressure.on_disc();
  const auto disc_kPa = [&](double kPa) {
    return on_disc ? number(kPa * *on_disc) : json(nullptr);
  };
  json j = {{"from_kPa", number(r.range.from_kPa)},
            {"to_kPa", number(r.range.to_kPa)},
            {"sensitivity_fF_per_kPa", value_of(r.sensitivity)},
            {"standard_error", error_of(r.sensitivity)},
            {"ci95", ci95(r.sensitivity)},
            {"estimand", r.sensitivity.estimand},
            {"degrees_of_freedom", nullptr},
            {"r_squared", number(r.r_squared)},
            {"intercept_fF", number(r.intercept_fF)},
            {"mean_kPa", number(r.mean_kPa)},
            {"mean_delta_C_fF", number(r.mean_delta_C_fF)},
            {"points", r.points},
            {"pressures", r.pressures},
            {"readings", r.sensitivity.rows},
            {"residual_fF", number(r.residual_fF)},
            {"lack_of_fit_p", number(r.lack_of_fit_p)},
            {"runs_p", number(r.runs_p)},
            {"residual_pattern", r.residual_pattern},
            {"scatter", r.scatter_basis},
            {"slope_of_repeat", r.slope_of_repeat},
            {"between_repeats_p", number(r.between_repeats_p)},
            {"remark", r.sensitivity.reason},
            {"expanded_uncertainty", nullptr},
            {"not_included", r.uncertainty.gaps()},
            {"on_disc",
             {{"from_kPa", disc_kPa(r.range.from_kPa)},
              {"to_kPa", disc_kPa(r.range.to_kPa)},
              {"sensitivity_fF_per_kPa", nullptr}}},
            {"robust", nullptr}};
  if (r.sensitivity && on_disc) {
    j["on_disc"]["sensitivity_fF_per_kPa"] = number(r.sensitivity.value() / *on_disc);
  }
  if (r.sensitivity) j["degrees_of_freedom"] = number(r.sensitivity.estimate->degrees_of_freedom);
  if (!r.uncertainty.parts.empty()) j["expanded_uncertainty"] = number(r.uncertainty.expanded);
  if (r.robust) {
    j["robust"] = {{"sensitivity_fF_per_kPa", number(r.robust->slope_fF_per_kPa)},
                   {"standard_error", number(r.robust->standard_error)},
                   {"down_weighted", r.robust->down_weighted}};
  }
  return j;
}

json of(const LevelResult& l) {
  return {{"level", l.level},
          {"repeat", l.repeat},
          {"index", l.index},
          {"direction", to_string(l.direction)},
          {"t_s", number(l.t_s)},
          {"target_kPa", number(l.target_kPa)},
          {"pressure_kPa", number(l.pressure_kPa)},
          {"capacitance_pF", number(l.capacitance_pF)},
          {"drift_fF", number(l.drift_fF)},
          {"delta_C_fF", number(l.delta_C_fF)},
          {"standard_error_fF", number(l.standard_error_fF)},
          {"scatter_fF", number(l.scatter_fF)},
          {"readings", l.readings},
          {"missing", l.missing},
          {"outliers", l.outliers}};
}

json of(const CurvePoint& c) {
  return {{"direction", to_string(c.direction)},
          {"pressure_kPa", number(c.pressure_kPa)},
          {"capacitance_pF", number(c.capacitance_pF)},
          {"delta_C_fF", number(c.delta_C_fF)},
          {"standard_error_fF", number(c.standard_error_fF)},
          {"repeats", c.repeats},
          {"readings", c.readings}};
}

json of(const CycleResult& c) {
  return {{"cycle", c.number},
          {"begin_s", number(c.begin_s)},
          {"peak_s", number(c.peak_s)},
          {"end_s", number(c.end_s)},
          {"peak_force_N", number(c.peak_force_N)},
          {"peak_kPa", number(c.peak_kPa)},
          {"peak_travel_mm", number(c.peak_travel_mm)},
          {"rest_s", number(c.rest_s)},
          {"rest_pF", number(c.rest_pF)},
          {"rest_standard_error_fF", number(c.rest_se_fF)},
          {"peak_pF", number(c.peak_pF)},
          {"peak_standard_error_fF", number(c.peak_se_fF)},
          {"peak_method", to_string(c.peak_method)},
          {"delta_C_fF", number(c.delta_C_fF)},
          {"delta_C_standard_error_fF", number(c.delta_C_se_fF)},
          {"dynamic_range_percent", number(c.dynamic_range_percent)},
          {"dynamic_range_standard_error_percent", number(c.dynamic_range_se_percent)},
          {"slope_fF_per_N", number(c.slope_fF_per_N)},
          {"slope_standard_error_fF_per_N", number(c.slope_se_fF_per_N)},
          {"loaded_readings", c.loaded_readings}};
}

json of(const HoldResult& h) {
  return {{"cycle", h.cycle},
          {"step", h.step_id},
          {"begin_s", number(h.begin_s)},
          {"end_s", number(h.end_s)},
          {"mean_force_N", number(h.mean_force_N)},
          {"force_change_percent", number(h.force_change_percent)},
          {"readings", h.readings},
          {"change_fF", number(h.change_fF)},
          {"change_standard_error_fF", number(h.change_se_fF)},
          {"per_decade_fF", number(h.per_decade_fF)},
          {"per_decade_standard_error_fF", number(h.per_decade_se_fF)},
          {"drift_fF_per_s", number(h.drift_fF_per_s)},
          {"drift_standard_error_fF_per_s", number(h.drift_se_fF_per_s)},
          {"resolved", h.resolved},
          {"time_constant_s", number(h.time_constant_s)},
          {"settling_s", number(h.settling_s)},
          {"remark", h.reason}};
}

json of(const Outlier& o) {
  return {{"t_s", number(o.t_s)},
          {"level", o.level},
          {"index", o.index},
          {"capacitance_pF", number(o.capacitance_pF)},
          {"deviation_fF", number(o.deviation_fF)},
          {"standard_deviations", number(o.deviations)}};
}

json of(const DriftInLevels& d) {
  return {{"levels", d.levels},
          {"largest_fF", number(d.largest_fF)},
          {"largest_at_kPa", number(d.kPa)},
          {"largest_percent", number(d.percent)}};
}

json of(const Hysteresis& h) {
  json loop = json::array();
  for (const LoopPoint& p : h.loop) {
    loop.push_back({{"force_N", number(p.force_N)},
                    {"loading_fF", number(p.up_fF)},
                    {"unloading_fF", number(p.down_fF)},
                    {"gap_standard_error_fF", number(p.gap_se_fF)}});
  }
  return {{"resolved", h.resolved},
          {"alignment_percent", number(h.alignment_percent)},
          {"uncorrected_percent", number(h.uncorrected_percent)},
          {"loop", std::move(loop)}};
}

json of(const RegionSearch& s, const PressureArea& pressure) {
  if (!s.reason.empty()) return {{"remark", s.reason}};
  return {{"low", of(s.low, pressure)},
          {"high", of(s.high, pressure)},
          {"low_to_kPa", number(s.low_to_kPa)},
          {"high_from_kPa", number(s.high_from_kPa)},
          {"p_one_line", number(s.p_one_line)}};
}

template <class T>
json list(const std::vector<T>& items) {
  json out = json::array();
  for (const T& item : items) out.push_back(of(item));
  return out;
}

json rig_of(const RigAccuracy& r) {
  return {{"force_class_percent", number(r.force_class_percent)},
          {"force_certified_from_N", number(r.force_certified_from_N)},
          {"probe_diameter_tolerance_mm", number(r.probe_diameter_tolerance_mm)},
          {"stray_limit_fF", number(r.stray_limit_fF)},
          {"temperature_C", number(r.meter.temperature_C)},
          {"cable_m", number(r.meter.cable_m)},
          {"interpolated_correction", r.meter.interpolated_correction}};
}

}  // namespace

json to_json(const Uncertainty& b) {
  json parts = json::array();
  for (const UncertaintyPart& p : b.parts) {
    parts.push_back({{"part", p.name},
                     {"standard_uncertainty", p.is_gap ? json() : number(p.standard_uncertainty)},
                     {"included", !p.is_gap},
                     {"kind", to_string(p.kind)},
                     {"degrees_of_freedom", number(p.degrees_of_freedom)},
                     {"shrinks_with_readings", p.shrinks},
                     {"source", to_string(p.source)},
                     {"basis", p.basis}});
  }
  return {{"quantity", b.quantity},
          {"unit", b.unit},
          {"estimand", b.estimand},
          {"value", number(b.value)},
          {"parts", std::move(parts)},
          {"combined_standard_uncertainty", number(b.combined)},
          {"effective_degrees_of_freedom", number(b.effective_degrees_of_freedom)},
          {"coverage_factor", number(b.coverage_factor)},
          {"expanded_uncertainty", number(b.expanded)},
          {"confidence", number(b.confidence)},
          {"not_included", b.gaps()}};
}

json to_json(const RunAnalysis& a) {
  json metrics = json::object();
  for (const Metric* m : a.metrics()) {
    if (a.range_of(*m) == nullptr) metrics[m->name] = of(*m);
  }
  json ranges = json::array();
  for (const RangeResult& r : a.ranges) ranges.push_back(of(r, a.pressure));
  json uncertainties = json::array();
  for (const Uncertainty& b : a.uncertainties) uncertainties.push_back(to_json(b));
  return {{"run", a.run},
          {"protocol", a.protocol},
          {"specimen", a.specimen},
          {"function", a.function},
          {"simulated", a.simulated},
          {"exit_status", a.exit_status ? json(to_string(*a.exit_status)) : json(nullptr)},
          {"proof_known", a.proof_known},
          {"unproven_readings", a.unproven_readings},
          {"C0_pF", value_of(a.c0)},
          {"C0_standard_error_pF", error_of(a.c0)},
          {"noise_fF", value_of(a.noise)},
          {"pressure", to_json(a.pressure)},
          {"ranges", std::move(ranges)},
          {"regions", a.regions ? of(*a.regions, a.pressure) : json(nullptr)},
          {"dynamic_range_percent", value_of(a.dynamic_range)},
          {"hysteresis_percent", value_of(a.hysteresis.largest_gap)},
          {"hysteresis", of(a.hysteresis)},
          {"metrics", std::move(metrics)},
          {"levels", list(a.levels)},
          {"curve", list(a.curve)},
          {"cycles", list(a.cycles)},
          {"cycles_left_out", list(a.left_out)},
          {"holds", list(a.holds)},
          {"outliers", list(a.outliers)},
          {"outlier_count", a.outlier_count},
          {"drift_in_levels", a.drift_in_levels ? of(*a.drift_in_levels) : json(nullptr)},
          {"hum", a.hum ? json{{"period_s", number(a.hum->period_s())},
                               {"amplitude_fF", number(a.hum->amplitude_fF())}}
                        : json(nullptr)},
          {"uncertainty", std::move(uncertainties)},
          {"confidence", number(a.options.confidence)},
          {"meaning", {{"ci95", kOfScatter}, {"expanded_uncertainty", kOfAll}}},
          {"rig", rig_of(a.options.rig)},
          {"identities", identities_json(a.conditions)},
          {"notes", a.notes}};
}

}  // namespace lcrig
