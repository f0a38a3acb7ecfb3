// SPDX-License-Identifier: Apache-2.0
// One execution of a `measure` step. The step creates it, the recorder stores it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/time.hpp"

namespace lcrig {

// A load level whose readings belong together.
struct LoadLevel {
  std::int64_t level = 0;  // 1, 2, ... within the run
  std::string step_id;
  std::int64_t repeat = 0;  // pass of the outermost `repeat` around it, from 1; 0: none
  std::int64_t index = 0;  // its position within that repeat, from 1
  std::optional<double> target_force_N;
  std::optional<double> target_pressure_Pa;
  std::int64_t planned_readings = 0;
  MonoTime begin;
};

}  // namespace lcrig
