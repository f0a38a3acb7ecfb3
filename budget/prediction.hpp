// SPDX-License-Identifier: Apache-2.0
// Predicts how well a planned run will measure, for search.hpp and `lcrig rehearse --batch`. It
// applies the estimators of analysis.hpp to the readings that the plan says will be taken, with the
// scatter of the instruments, and simulates nothing. docs/report.md, "Budget", has the formulas.
#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analysis/analysis.hpp"

namespace lcrig {

// One `measure` step.
struct PlannedLevel {
  double pressure_kPa = 0;
  double readings = 0;
  int repeat = 1;
  double t_s = 0;  // mean time of its readings
};

// Part of a loading, with readings spread evenly over its forces.
struct PlannedStretch {
  double from_kPa = 0, to_kPa = 0;
  double readings = 0, seconds = 0;
  bool is_level = false;  // the readings are those of a `measure` step
  bool operator==(const PlannedStretch&) const = default;
};

// One excursion of the force.
struct PlannedCycle {
  double peak_kPa = 0, peak_s = 0;
  std::vector<PlannedStretch> rising;  // levels, and ramps of force
  double loading_s = 0;  // of a continuous loading at constant speed, from contact to peak; else 0
  double falling_s = 0;  // from the peak until nothing touches
};

// A stretch without load: mean time and number of those readings that the analysis uses.
struct PlannedRest {
  double t_s = 0, readings = 0;
};

struct PlannedRun {
  MeterSetting meter;
  double reading_noise_F = 0;  // standard deviation of one reading
  std::string noise_basis = "noise of the meter";
  bool noise_guessed = false;  // the noise was not measured with this aperture
  double force_noise_N = 0;  // of one sample of the frame
  double interval_s = 0;  // between readings of a continuous record
  // In a continuous record each reading is found `later_s` later after its conversion than the one
  // before. When the delay has grown to `earlier_s`, the driver asks that much earlier again.
  double later_s = 0, earlier_s = 0;
  double sample_s = 0;  // between samples of the frame
  double area_m2 = 0;  // that pressures are over: of `pressure`
  PressureArea pressure;
  double c0_F = 0;
  std::function<double(double kPa)> delta_C_fF;  // of the specimen
  std::function<double(double force_N)> compression_m;  // of specimen and frame together
  bool dead_weights = false;
  std::optional<double> force_class_percent;  // of the load cell; absent: not stated
  std::vector<PlannedLevel> levels;  // at rising pressure
  std::vector<PlannedCycle> cycles;
  std::vector<PlannedRest> rests;  // one before each cycle, and possibly one after the last
};

struct Prediction {
  std::string quantity;  // "sensitivity 0-30 kPa"
  std::string unit;
  std::string reason;  // why there is no prediction; empty: the members below are filled
  double value = 0;  // according to the model
  // The standard error that `analyze` is expected to print. The mean of quick cycles scatters a
  // little less between runs, because the readings of one cycle fall between those of the others.
  double standard_error = 0;
  // Half of the interval that `analyze` is expected to print. With few repeats it is much more than
  // two standard errors, because the repeats must tell their own scatter.
  double half_width = 0;
  int repeats = 0;  // repeats or cycles: size of the sample that the interval comes from
  Uncertainty uncertainty;  // includes the systematic parts
  double relative_half_width() const { return half_width / std::abs(value); }
  double relative() const { return standard_error / std::abs(value); }
};

// Predicts the sensitivity in each range, then the dynamic range. Errors: a reading noise, interval
// or area that is not positive; a setting of the meter outside its tables.
Result<std::vector<Prediction>> predict_errors(const PlannedRun& run,
                                               const AnalysisOptions& options = {});

}  // namespace lcrig
