// SPDX-License-Identifier: Apache-2.0
// The scene decides the physics: the cheapest level whose estimated error meets the tolerance.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "model/level.hpp"

namespace lcrig {

// An effect that no level here contains, with what it would do to delta C (or C0) if it did.
struct Omission {
  std::string effect;
  double relative_size = 0;
  std::string note;  // how the size was estimated
};

struct LevelChoice {
  LevelSettings settings;
  double error_estimate = 0;  // relative, of delta C at max_pressure, against the best level
  std::string reason;
  std::vector<Omission> left_out;
};

// Errors: the specimen is wrong; no level meets the tolerance (the message names the best one).
Result<LevelChoice> choose_level(const Specimen& specimen, double tolerance, Pressure max_pressure);

// For the run row and `--json`.
nlohmann::json to_json(const LevelChoice& choice);
std::string to_text(const LevelChoice& choice);  // several lines

}  // namespace lcrig
