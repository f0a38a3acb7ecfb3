// SPDX-License-Identifier: Apache-2.0
// How much the results of a planned run will scatter: the estimators of the analysis, applied to
// the readings that the plan says will be taken. Private to budget/.
#pragma once

#include <optional>

#include "budget/prediction.hpp"

namespace lcrig {

struct Scatter {
  double value = 0;  // what the model lets expect
  double meter = 0, force = 0;  // standard errors that the noise of the two makes
  // Standard error by chance: where on a loading at constant speed the readings fall, and its turn.
  double instants = 0;
  // Standard error that the noise of the rests makes: of the drift that is subtracted, alike in all
  // repeats.
  double drift = 0;
  // Standard uncertainty of what no repeating shows: the common error of the instants of readings,
  // and windows that reach over the turn.
  double alignment = 0, turn = 0;
};

// From levels, else from the loading branches. nullopt: fewer than two different pressures.
std::optional<Scatter> scatter_of_slope(const PlannedRun& run, const PressureRange& range);
// nullopt: no reading is taken at rest, or none under load.
std::optional<Scatter> scatter_of_dynamic_range(const PlannedRun& run);

// Slope of the curve at even pressures over the part of the range that a loading reaches, as in the
// analysis.
double even_slope(const PlannedRun& run, const PressureRange& range, double peak_kPa);

// Standard error of the rate of drift, from the noise of the rests; 0: none is subtracted.
double rate_error_fF_s(const PlannedRun& run);

// Time over which the meter takes the mean, and standard uncertainty of a reading's instant.
double window_s(const PlannedRun& run);
double instant_s(const PlannedRun& run);

// Standard deviation of the pressure at the instant of a reading.
double force_noise_kPa(const PlannedRun& run);

}  // namespace lcrig
