// SPDX-License-Identifier: Apache-2.0
// Time against error of every level and mesh for one scene: what `lcrig model ladder` prints.
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
  std::string setting;  // "mesh 1, 2328 unknowns"
  double seconds = 0;  // from the specimen to the answer, best of three where it is quick
  double relative_error = 0;  // of delta C against the reference
  std::optional<double> error_estimate;  // what `auto` believes
  std::optional<Pressure> lost_beyond;  // the estimate holds here: finite strain has no more
  std::string failure;  // why there is no answer; empty otherwise
  bool reference = false;
};

struct Ladder {
  Pressure pressure;
  // Of the reference: with free faces the exact solution, else where the meshes of finite strain
  // lead, or those of small strain where it has no solution.
  double delta_capacitance_F = 0;
  double reference_doubt = 0;  // relative: smaller errors are not told apart
  std::string reference;  // in words
  std::vector<LadderRow> rows;  // cheapest first
};

// `seconds_now` is a clock for the timing (the model has none). Errors: the specimen is wrong; no
// level at all can answer.
Result<Ladder> climb_ladder(const Specimen& specimen, Pressure pressure,
                            const std::function<double()>& seconds_now);

nlohmann::json to_json(const Ladder& ladder);
std::string to_table(const Ladder& ladder);

}  // namespace lcrig
