// SPDX-License-Identifier: Apache-2.0
#include "budget/prediction.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "analysis/line_fit.hpp"
#include "analysis/metrics.hpp"
#include "budget/scatter.hpp"

namespace lcrig {

namespace {

void add(Uncertainty& uncertainty, std::string name, double size, UncertaintyKind kind,
         std::string basis) {
  UncertaintyPart part;
  part.name = std::move(name);
  part.standard_uncertainty = size;
  part.kind = kind;
  part.shrinks = kind == UncertaintyKind::a;
  part.basis = std::move(basis);
  uncertainty.parts.push_back(std::move(part));
}

// Adds an error of the rig. `per_unit`: change of the result for an error of one.
void add_error(Uncertainty& uncertainty, std::string name, const RigError& error, double per_unit) {
  uncertainty.parts.push_back(part_of(std::move(name), error, std::abs(per_unit)));
}

RigErrors rig_errors_of(const PlannedRun& run, const RigAccuracy& rig) {
  RigRecord record;
  record.setting = run.meter;
  record.probe_diameter_m = std::sqrt(4 * run.area_m2 / std::numbers::pi);
  record.pressure = run.pressure;
  record.dead_weights = run.dead_weights;
  record.force_class_percent = run.force_class_percent;
  record.planned = true;
  return rig_errors(record, rig, run.c0_F);
}

Prediction predicted(std::string quantity, std::string unit, const Scatter& parts,
                     const PlannedRun& run) {
  Prediction p;
  p.quantity = p.uncertainty.quantity = std::move(quantity);
  p.unit = p.uncertainty.unit = std::move(unit);
  p.value = p.uncertainty.value = parts.value;
  p.standard_error = std::hypot(std::hypot(parts.meter, parts.force, parts.instants), parts.drift);
  add(p.uncertainty, "scatter of the readings", parts.meter, UncertaintyKind::a, run.noise_basis);
  add(p.uncertainty, "scatter of the force", parts.force, UncertaintyKind::a,
      "noise of the load cell");
  if (parts.instants > 0) {
    add(p.uncertainty, "instants of the readings", parts.instants, UncertaintyKind::a,
        "where on a loading the readings fall, and when it turns");
  }
  if (parts.drift > 0) {
    add(p.uncertainty, "drift of C0", parts.drift, UncertaintyKind::a,
        "what the scatter of the rests leaves of it");
    p.uncertainty.parts.back().alike_in_repeats = true;
  }
  return p;
}

Prediction not_predicted(std::string quantity, std::string unit, std::string reason) {
  Prediction p;
  p.quantity = std::move(quantity);
  p.unit = std::move(unit);
  p.reason = std::move(reason);
  return p;
}

// Mean of a standard deviation estimated from `repeats`, over the true one: a little less than 1.
double mean_deviation(int repeats) {
  if (repeats < 2) return 1;
  const double freedom = repeats - 1;
  return std::sqrt(2 / freedom) * std::exp(std::lgamma(repeats / 2.0) - std::lgamma(freedom / 2));
}

// Sets the interval and combines all parts. As in the analysis, the scatter is known only from the
// repeats.
void finish(int repeats, double confidence, Prediction& p) {
  double drift = 0;
  for (const UncertaintyPart& part : p.uncertainty.parts) {
    if (part.alike_in_repeats) drift = part.standard_uncertainty;
  }
  SlopePart own{std::sqrt(std::max(0.0, p.standard_error * p.standard_error - drift * drift))};
  if (repeats >= 2) own.degrees_of_freedom = repeats - 1;
  p.repeats = repeats;
  const Estimate printed = estimate_of_parts(
      0, {{own.se * mean_deviation(repeats), own.degrees_of_freedom}, {drift}}, confidence);
  p.half_width = (*printed.interval)[1];
  Uncertainty told = p.uncertainty;
  std::erase_if(told.parts, [](const UncertaintyPart& part) {
    return part.kind == UncertaintyKind::a && !part.alike_in_repeats;
  });
  add(told, "scatter", own.se, UncertaintyKind::a, "");
  told.parts.back().degrees_of_freedom = own.degrees_of_freedom;
  told.least = p.half_width;
  combine(told, confidence);
  told.parts = std::move(p.uncertainty.parts);
  p.uncertainty = std::move(told);
}

// Number of loadings, or of repeats that have a slope of their own in the range.
int slopes_in(const PlannedRun& run, const PressureRange& range) {
  if (run.levels.empty()) return static_cast<int>(run.cycles.size());
  std::map<int, int> levels;  // number of levels by repeat
  for (const PlannedLevel& l : run.levels) {
    if (is_inside(range, l.pressure_kPa) && l.readings > 0) ++levels[l.repeat];
  }
  std::erase_if(levels, [](const auto& repeat) { return repeat.second < 2; });
  return static_cast<int>(levels.size());
}

Prediction predict_sensitivity(const PlannedRun& run, const PressureRange& range,
                               const RigErrors& rig, double confidence) {
  const std::string name = fmt::format("sensitivity {:g}-{:g} kPa", range.from_kPa, range.to_kPa);
  const auto parts = scatter_of_slope(run, range);
  if (!parts) {
    return not_predicted(name, "fF/kPa", "fewer than two different pressures lie in the range");
  }
  Prediction p = predicted(name, "fF/kPa", *parts, run);
  for (UncertaintyPart& part : parts_of_meter_gain(rig, p.value)) {
    p.uncertainty.parts.push_back(std::move(part));
  }
  add_error(p.uncertainty, "force", rig.force, p.value);
  add_error(p.uncertainty, name_of_area(rig), rig.area, p.value);
  if (parts->alignment > 0) {
    add(p.uncertainty, "alignment of the clocks", parts->alignment, UncertaintyKind::b,
        "one error of the instant of all readings, where the rate of pressure changes");
  }
  finish(slopes_in(run, range), confidence, p);
  return p;
}

// The meter's gain cancels in the ratio, but its offset stays in C0. The force is the abscissa: the
// dynamic range is defined at the force that was asked for.
Prediction predict_range(const PlannedRun& run, const RigErrors& rig, double confidence) {
  const auto parts = run.cycles.empty() ? std::nullopt : scatter_of_dynamic_range(run);
  if (!parts) {
    return not_predicted("dynamic range", "%",
                         run.cycles.empty() ? "the protocol never loads and unloads"
                                            : "no reading is taken at rest, or none at the peak");
  }
  Prediction p = predicted("dynamic range", "%", *parts, run);
  add_error(p.uncertainty, "meter offset in C0", rig.meter_offset, p.value / run.c0_F);
  p.uncertainty.parts.push_back(part_of_open_correction(rig, p.value / run.c0_F));
  const PlannedCycle& c = run.cycles.front();
  const double h = 0.01 * c.peak_kPa;
  const double slope = (run.delta_C_fF(c.peak_kPa + h) - run.delta_C_fF(c.peak_kPa - h)) / (2 * h);
  const double bend = slope * c.peak_kPa / run.delta_C_fF(c.peak_kPa);
  add_error(p.uncertainty, "force at the peak", rig.force, bend * p.value);
  add_error(p.uncertainty, name_of_area(rig), rig.area, bend * p.value);
  if (parts->turn > 0) {
    add(p.uncertainty, "turn within a window", parts->turn, UncertaintyKind::b,
        "a twelfth of rate times window");
  }
  finish(static_cast<int>(run.cycles.size()), confidence, p);
  return p;
}

}  // namespace

Result<std::vector<Prediction>> predict_errors(const PlannedRun& run,
                                               const AnalysisOptions& options) {
  if (!(run.reading_noise_F > 0) || !(run.interval_s > 0) || !(run.area_m2 > 0) ||
      !(run.c0_F > 0)) {
    return fail(Errc::invalid_request,
                "a budget needs the noise and the time of a reading, the probe's area and C0");
  }
  const auto meter = meter_accuracy(run.meter, options.rig.meter, run.c0_F);
  if (!meter) return fail(meter.error());
  const RigErrors rig = rig_errors_of(run, options.rig);
  std::vector<Prediction> out;
  out.reserve(options.ranges.size() + 1);
  for (const PressureRange& range : options.ranges) {
    out.push_back(predict_sensitivity(run, range, rig, options.confidence));
  }
  out.push_back(predict_range(run, rig, options.confidence));
  return out;
}

}  // namespace lcrig
