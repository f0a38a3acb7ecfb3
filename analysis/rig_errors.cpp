// SPDX-License-Identifier: Apache-2.0
#include "analysis/rig_errors.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "base/force_class.hpp"

namespace lcrig {

namespace {

RigError error_of_force(const RigRecord& record, const RigAccuracy& stated) {
  const double percent =
      force_limit_percent(stated, record.force_class_percent, record.dead_weights);
  const char* from = stated.force_class_percent                           ? "; as stated"
                     : record.force_class_percent && !record.dead_weights ? "; of the run's rig"
                                                                          : "; assumed";
  return {percent / 100,
          fmt::format("{}: limits of {} % of reading, rectangular{}",
                      record.dead_weights ? "masses and local g" : "force class (ISO 7500-1)",
                      percent, from)};
}

RigError error_of_area(const RigRecord& record, const RigAccuracy& stated) {
  const bool on_disc = record.pressure.on == PressureOn::disc;
  const auto diameter_m = on_disc ? record.pressure.disc_diameter_m : record.probe_diameter_m;
  if (!diameter_m)
    return {{}, fmt::format("the {}'s diameter is not known", to_string(record.pressure.on))};
  const double limit_mm = on_disc ? record.pressure.limit_m() * 1e3 : stated.diameter_limit_mm();
  const double diameter_mm = *diameter_m * 1e3;
  return {2 * limit_mm / diameter_mm,
          fmt::format("diameter {:g} mm, limits of {} mm, rectangular{}", diameter_mm, limit_mm,
                      stated.probe_diameter_tolerance_mm && !on_disc ? "" : "; assumed")};
}

// "18 to 28 degrees Celsius"; the factor Kc is the same within these.
std::string place_text(const MeterPlace& place) {
  std::string out = place.temperature_C
                        ? fmt::format("; {:g} degrees Celsius", *place.temperature_C)
                        : fmt::format("; {:g} degrees Celsius assumed", kAssumedTemperature_C);
  if (!place.cable_m) out += ", leads of 0 m assumed";
  return out;
}

void set_errors_of_meter(const RigRecord& record, const RigAccuracy& stated, double capacitance_F,
                         RigErrors& out) {
  const auto unknown = [&out](const std::string& why) {
    out.meter_gain.basis = out.meter_offset.basis = out.meter_total.basis = why;
  };
  if (!record.setting) return unknown("the run does not tell the settings of the meter");
  const auto a = meter_accuracy(*record.setting, stated.meter, capacitance_F);
  if (!a) return unknown(a.error().what);
  const std::string place = place_text(stated.meter) + (a->note.empty() ? "" : "; ") + a->note;
  out.meter_gain = {a->gain, fmt::format("proportional part of the basic accuracy: limits of "
                                         "{:.3g} %, rectangular{}",
                                         a->gain * 100, place)};
  out.meter_offset = {a->offset_F,
                      fmt::format("part of the basic accuracy that stays the same while the "
                                  "settings stay: limits of {:.3g} fF, rectangular{}",
                                  a->offset_F * 1e15, place)};
  out.meter_total = {
      a->total * capacitance_F,
      fmt::format("basic accuracy: limits of {:.3g} %, rectangular{}", a->total * 100, place)};
}

const char* unknown_state(const RigRecord& record) {
  return record.planned ? "whether it will be on is not known"
                        : "whether it was on is not recorded";
}

// A parallel capacitance adds to every reading and to no change.
RigError error_of_open(const RigRecord& record, const RigAccuracy& stated) {
  const auto& meter = record.corrections;
  const auto on = meter ? meter->open.on : std::nullopt;
  if (on == true) return {0, correction_words(meter->open, record.at_unix_ns)};
  const std::string state = on ? "off" : unknown_state(record);
  const auto recorded_F = meter ? meter->stray_limit_F : std::nullopt;
  if (!stated.stray_limit_fF && !recorded_F) {
    return {{},
            state +
                ": the capacitance of leads and fixture is in every reading, and its limit is "
                "not known (fixture.stray_limit_fF of the config, or --stray-limit-fF)"};
  }
  const double limit_F = stated.stray_limit_fF ? *stated.stray_limit_fF * 1e-15 : *recorded_F;
  return {limit_F, fmt::format("{}: capacitance of leads and fixture, limits of {:.3g} fF, "
                               "rectangular; {}",
                               state, limit_F * 1e15,
                               stated.stray_limit_fF ? "as stated" : "of the run's rig")};
}

// A series impedance of 1 ohm changes the reading by at most 1 ohm over the impedance.
RigError error_of_short(const RigRecord& record, double capacitance_F) {
  const auto& meter = record.corrections;
  const auto on = meter ? meter->short_circuit.on : std::nullopt;
  if (on == true) return {0, correction_words(meter->short_circuit, record.at_unix_ns)};
  std::string why = on ? "off" : unknown_state(record);
  why += ": the series impedance of leads and fixture is in every reading";
  if (record.setting && capacitance_F > 0) {
    const double per_ohm = 2 * std::numbers::pi * record.setting->frequency_Hz * capacitance_F;
    why += fmt::format("; each ohm of it is at most {:.2g} ppm of C", per_ohm * 1e6);
  }
  return {{}, why};
}

}  // namespace

double force_limit_percent(const RigAccuracy& stated, std::optional<double> recorded_percent,
                           bool dead_weights) {
  if (stated.force_class_percent) return *stated.force_class_percent;
  if (dead_weights) return 0.1;  // masses and local g
  return recorded_percent.value_or(kAssumedForceClass.percent());
}

RigErrors rig_errors(const RigRecord& record, const RigAccuracy& stated, double capacitance_F) {
  RigErrors out;
  out.force = error_of_force(record, stated);
  out.area = error_of_area(record, stated);
  out.area_of = record.pressure.on;
  set_errors_of_meter(record, stated, capacitance_F, out);
  out.open_correction = error_of_open(record, stated);
  out.short_correction = error_of_short(record, capacitance_F);
  out.leads.limit = 0;
  if (stated.meter.cable_m.value_or(0) > 0) {
    out.leads = {{},
                 fmt::format("{:g} m: KL of the basic accuracy is known for 0 m only",
                             *stated.meter.cable_m)};
  }
  out.force.source = ErrorSource::cell;
  out.area.source = out.area_of == PressureOn::probe ? ErrorSource::probe : ErrorSource::run;
  for (RigError* e : {&out.meter_gain, &out.meter_offset, &out.meter_total}) {
    e->source = ErrorSource::meter;
  }
  return out;
}

std::string name_of_area(const RigErrors& errors) {
  return fmt::format("area of the {}", to_string(errors.area_of));
}

UncertaintyPart part_of(std::string name, const RigError& error, double per_unit) {
  if (!error.limit) return gap(std::move(name), error.basis);
  UncertaintyPart p;
  p.name = std::move(name);
  p.standard_uncertainty = rectangular(*error.limit * per_unit);
  p.basis = error.basis;
  p.source = error.source;
  return p;
}

std::vector<UncertaintyPart> parts_of_meter_gain(const RigErrors& errors, double value) {
  std::vector<UncertaintyPart> out{part_of("meter gain", errors.meter_gain, value)};
  if (!errors.short_correction.limit) {
    out.push_back(part_of("short correction", errors.short_correction, value));
  }
  if (!errors.leads.limit) out.push_back(part_of("leads", errors.leads, value));
  return out;
}

UncertaintyPart part_of_open_correction(const RigErrors& errors, double per_F) {
  return part_of("open correction", errors.open_correction, per_F);
}

UncertaintyPart gap(std::string name, std::string why) {
  UncertaintyPart p;
  p.name = std::move(name);
  p.is_gap = true;
  p.basis = std::move(why);
  return p;
}

}  // namespace lcrig
