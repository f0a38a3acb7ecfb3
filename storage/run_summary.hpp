// SPDX-License-Identifier: Apache-2.0
// The few figures of a run that people want to see at once, for `lcrig rehearse` and `lcrig model
// fit`. Statistics belong to analysis/.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "storage/sqlite.hpp"

namespace lcrig {

struct RunSummary {
  // Proven readings (storage/proof.hpp); all of them where the proof is unknown.
  std::int64_t lcr_readings = 0;  // fresh ones only
  std::int64_t measure_readings = 0;  // taken by `measure` steps
  std::int64_t unproven_readings = 0;  // the other fresh ones
  std::int64_t frame_samples = 0;
  std::optional<double> duration_s;
  // Mean of the readings before contact, or before the first weight; absent without such an event.
  std::optional<double> c0_F;
  std::optional<double> peak_force_N;
  // Capacitance minus C0. The capacitance is the mean at the highest level of `measure` steps.
  // Without levels it is the mean of the readings nearest to the largest force of each loading.
  std::optional<double> delta_at_peak_F;
};
// The capacitances are present only if the meter functions of the run measure a capacitance.
Result<RunSummary> summarise_run(const Database& db, std::int64_t run);

// A specimen's capacitance before contact, from its last successful run at this frequency.
struct LastC0 {
  std::int64_t run = 0;
  double c0_F = 0;
};
Result<std::optional<LastC0>> last_c0(const Database& db, std::string_view specimen,
                                      double frequency_Hz);

}  // namespace lcrig
