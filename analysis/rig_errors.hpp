// SPDX-License-Identifier: Apache-2.0
// The errors of the rig that all readings of a run share: what is known of each, and from where. A
// result's uncertainty takes its parts from here, in the analysis, the report and the budget. What
// nobody recorded or stated is a gap: it is named, and no number stands for it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/meter_accuracy.hpp"
#include "analysis/uncertainty.hpp"
#include "base/pressure_area.hpp"
#include "storage/corrections.hpp"

namespace lcrig {

// Facts about the rig that a person states with the analysis. Where one is absent, what the run
// recorded counts, then an assumption, which is printed with the result, or the error is a gap.
struct RigAccuracy {
  std::optional<double> force_class_percent;  // limits of reading
  std::optional<double> force_certified_from_N;  // absent: not known
  std::optional<double> probe_diameter_tolerance_mm;  // limits; absent: kProbeLimit_m
  std::optional<double> stray_limit_fF;  // of leads and fixture, which an open correction removes
  MeterPlace meter;
  double diameter_limit_mm() const {
    return probe_diameter_tolerance_mm.value_or(kProbeLimit_m * 1e3);
  }
};

// What a run recorded of its rig, or what a plan foresees.
struct RigRecord {
  std::optional<MeterSetting> setting;
  std::optional<double> probe_diameter_m;
  PressureArea pressure;  // where it is over the disc, the disc counts instead of the probe
  bool dead_weights = false;
  std::optional<double> force_class_percent;  // of the load cell
  std::optional<MeterCorrections> corrections;  // absent: the run did not ask for them
  std::int64_t at_unix_ns = 0;  // the time of `corrections`
  bool planned = false;  // nothing is recorded yet
};

// Limits of an error between which all values are equally likely.
struct RigError {
  std::optional<double> limit;  // absent: a gap
  std::string basis;  // where the limit comes from, or why there is none
  ErrorSource source = ErrorSource::run;
};

struct RigErrors {
  RigError force, area;  // relative
  PressureOn area_of = PressureOn::probe;
  RigError meter_gain;  // relative
  RigError meter_offset, meter_total;  // F; the offset is constant while the settings are
  RigError open_correction;  // F, constant: the capacitance of leads and fixture
  RigError short_correction, leads;  // relative; only known to be none, or gaps
};
RigErrors rig_errors(const RigRecord& record, const RigAccuracy& stated, double capacitance_F);

// Limits of the force in percent of the reading.
double force_limit_percent(const RigAccuracy& stated, std::optional<double> recorded_percent,
                           bool dead_weights);

std::string name_of_area(const RigErrors& errors);  // "area of the probe"

// The part of a result that changes by `per_unit` for an error of one.
UncertaintyPart part_of(std::string name, const RigError& error, double per_unit);

// The errors of the meter that scale all changes of the capacitance. The corrections and leads are
// named only where they are gaps.
std::vector<UncertaintyPart> parts_of_meter_gain(const RigErrors& errors, double value);
// A capacitance parallel to the specimen. `per_F`: change of the result for one farad.
UncertaintyPart part_of_open_correction(const RigErrors& errors, double per_F);

// A part that is named but not in the uncertainty.
UncertaintyPart gap(std::string name, std::string why);

}  // namespace lcrig
