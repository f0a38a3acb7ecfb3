// SPDX-License-Identifier: Apache-2.0
// How often a run will read the settings of the meter back, and what that costs. A change that is
// shorter than the time between two read-backs may pass unnoticed.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>

#include "drivers/lcr_meter.hpp"

namespace lcrig {

struct PlannedReadBacks {
  // The longest time between two, s: while it records continuously, and in a `measure` step. 0:
  // there is no such part.
  double recording_s = 0, level_s = 0;
  double takes_s = 0;  // one of them
  double settling_s = 0;  // after a change of settings, without readings
  // Readings that they take from a continuous recording, per second, by aperture (fast, medium,
  // slow).
  std::array<double, 3> cost_per_s{};

  explicit PlannedReadBacks(const LcrCapabilities& meter = LcrCapabilities())
      : takes_s(to_seconds(meter.read_back)), settling_s(to_seconds(meter.settling)) {}
  void add_recording(const LcrSettings& settings, const LcrCapabilities& meter);
  void add_level(double readings, double within_s, const LcrSettings& settings,
                 const LcrCapabilities& meter);
};
nlohmann::json to_json(const PlannedReadBacks& plan);

}  // namespace lcrig
