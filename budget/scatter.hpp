// SPDX-License-Identifier: Apache-2.0
// Predicts how much the results of a planned run will scatter. It applies the estimators of the
// analysis to the readings that the plan says will be taken. Private to budget/.
#pragma once

#include <optional>

#include "budget/prediction.hpp"

namespace lcrig {

struct Scatter {
  double value = 0;  // according to the model
  double meter = 0, force = 0;  // standard errors from the noise of meter and force
  // Standard error from chance: where the readings fall on a loading at constant speed, and how far
  // the highest sample is from the turn.
  double instants = 0;
  // Standard error from the noise of the rests. It enters through the drift that is subtracted and
  // is the same in all repeats.
  double drift = 0;
  // Standard uncertainty of errors that repeating does not reveal: the common error of the
  // readings' instants, and windows that reach over the turn.
  double alignment = 0, turn = 0;
};

// From levels, else from the loading branches. nullopt: fewer than two different pressures.
std::optional<Scatter> scatter_of_slope(const PlannedRun& run, const PressureRange& range);
// nullopt: there is no reading at rest, or none under load.
std::optional<Scatter> scatter_of_dynamic_range(const PlannedRun& run);

// Slope of the curve with pressures spread evenly over the part of the range that a loading
// reaches, as in the analysis.
double even_slope(const PlannedRun& run, const PressureRange& range, double peak_kPa);

// Standard error of the rate of drift, from the noise of the rests. 0: no drift is subtracted.
double rate_error_fF_s(const PlannedRun& run);

// Time over which the meter averages, and standard uncertainty of a reading's instant.
double window_s(const PlannedRun& run);
double instant_s(const PlannedRun& run);

// Standard deviation of the pressure at the instant of a reading.
double force_noise_kPa(const PlannedRun& run);

}  // namespace lcrig
