// SPDX-License-Identifier: Apache-2.0
// Time and error of every level and mesh for one specimen. `lcrig model ladder` prints it.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "model/level.hpp"

namespace lcrig {

struct LadderRow {
  LevelSettings settings;
  std::string setting;  // "spring law", "mesh 1"
  double seconds = 0;  // from the specimen to the answer; the best of three if it is quick
  double relative_error = 0;  // of delta C against the reference
  std::optional<double> error_estimate;  // what `auto` would estimate
  // the estimate holds at this pressure, the highest that finite strain can solve
  std::optional<Pressure> lost_beyond;
  std::string failure;  // why there is no answer; empty otherwise
  bool reference = false;
};

struct Ladder {
  Pressure pressure;
  // Delta C of the reference. With free faces this is the exact solution. Otherwise it is the limit
  // of the meshes of finite strain, or of small strain where finite strain has no solution.
  double delta_capacitance_F = 0;
  double reference_doubt = 0;  // relative; smaller errors cannot be distinguished
  std::string reference;  // in words
  std::vector<LadderRow> rows;  // cheapest first
};

// `seconds_now` is a clock for the timing, because the model has none. Errors: the specimen is
// wrong, or no level can give an answer.
Result<Ladder> climb_ladder(const Specimen& specimen, Pressure pressure,
                            const std::function<double()>& seconds_now);

nlohmann::json to_json(const Ladder& ladder);
std::string to_table(const Ladder& ladder);

}  // namespace lcrig
