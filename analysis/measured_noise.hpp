// SPDX-License-Identifier: Apache-2.0
// Reads the scatter of the instruments from a recorded run. `lcrig budget` can predict from it
// instead of from a specification.
#pragma once

#include <cstdint>
#include <optional>

#include "analysis/meter_accuracy.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

struct MeasuredNoise {
  MeterSetting meter;  // the setting under which the readings were taken
  double reading_F = 0;  // standard deviation of one reading
  std::optional<double> force_N;  // of one sample; absent: no force was recorded
};
// Errors: those of analyse; the run does not tell its settings or its noise.
Result<MeasuredNoise> measured_noise(const Database& db, std::int64_t run);

}  // namespace lcrig
