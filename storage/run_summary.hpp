// SPDX-License-Identifier: Apache-2.0
// The few figures of a run that a person wants to see at once. Statistics are analysis' business.
#pragma once

#include <cstdint>
#include <optional>

#include "storage/sqlite.hpp"

namespace lcrig {

struct RunSummary {
  RunSummary() = default;
  std::int64_t lcr_readings = 0;  // fresh ones
  std::int64_t measure_readings = 0;  // that a `measure` step counted
  std::int64_t frame_samples = 0;
  std::optional<double> duration_s;
  // Mean of the readings before contact (before the first weight); absent without such an event.
  std::optional<double> c0_F;
  std::optional<double> peak_force_N;
  // Capacitance minus C0: the mean at the highest level of `measure` steps; without levels the mean
  // over loadings of the reading nearest to each one's largest force.
  std::optional<double> delta_at_peak_F;
};
// The run's functions must measure a capacitance for the capacitances to be there.
Result<RunSummary> summarise_run(const Database& db, std::int64_t run);

}  // namespace lcrig
