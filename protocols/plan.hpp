// SPDX-License-Identifier: Apache-2.0
// Expands a protocol without instruments: what it will do, how long, how far, and whether limits
// and instruments allow it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "protocols/check.hpp"

namespace lcrig {

// One step of the file; loops are summarised.
struct PlannedStep {
  PlannedStep() = default;
  std::string id, kind;
  double start_s = 0;  // of the first time
  double duration_s = 0;  // of the first time
  std::int64_t times = 0;
  double total_s = 0;  // of all times
  std::string note;  // what was chosen or assumed, and why; of the first time
  bool in_finally = false;
};

struct Plan {
  Plan() = default;
  BoundLimits limits;
  LcrSettings lcr;  // at the start, with the aperture that was chosen
  std::string aperture_note;  // the arithmetic behind it
  double duration_s = 0;  // with `finally`
  std::int64_t measure_readings = 0;  // planned fresh readings of `measure` steps
  std::int64_t lcr_readings = 0, frame_samples = 0;  // recorded in all, about
  double peak_force_N = 0;  // commanded or predicted, without overshoot
  double overshoot_N = 0;  // largest predicted
  double travel_min_m = 0, travel_max_m = 0;  // envelope of machine travel; 0 0 without motion
  std::int64_t bytes = 0;  // of the database, about
  std::vector<std::string> assumptions;
  std::vector<PlannedStep> steps;
};

// Errors: invalid_request, "PROTOCOL:LINE:COL /pointer (step id): reason with its arithmetic".
Result<Plan> make_plan(const Protocol& protocol, const Environment& environment, const Rig& rig);
// The same checks, when only the answer counts.
Result<> check_protocol(const Protocol& protocol, const Environment& environment, const Rig& rig);

// As in design.md section 10, fields added.
nlohmann::json to_json(const Plan& plan);

}  // namespace lcrig
