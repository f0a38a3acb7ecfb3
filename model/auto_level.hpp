// SPDX-License-Identifier: Apache-2.0
// The scene decides the physics: the cheapest level whose estimated error meets the tolerance.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "model/error_estimate.hpp"

namespace lcrig {

// An effect that no level here contains, with what it would do to delta C (or C0) if it did.
struct Omission {
  std::string effect;
  double relative_size = 0;
  std::string note;  // how the size was estimated
};

struct LevelChoice {
  LevelSettings settings;
  double error_estimate = 0;  // relative, of delta C at max_pressure or where that is lost
  // Finite strain loses its solution here, below max_pressure: beyond lies extrapolation.
  std::optional<Pressure> lost_beyond;
  std::string reason;
  std::vector<Omission> left_out;
};

// How long the search may take. The model has no clock: the caller lends one.
struct WorkBudget {
  double seconds = 0;
  std::function<double()> seconds_now;
};

// Errors: the specimen is wrong; no level meets the tolerance, or none within the budget (the
// message names the best one, and what a finer one would cost).
Result<LevelChoice> choose_level(const Specimen& specimen, double tolerance, Pressure max_pressure,
                                 const std::optional<WorkBudget>& budget = std::nullopt);
// The same with what the estimator has solved before.
Result<LevelChoice> choose_level(ErrorEstimator& estimator, double tolerance, Pressure max_pressure,
                                 const std::optional<WorkBudget>& budget = std::nullopt);

// For the run row and `--json`.
nlohmann::json to_json(const LevelChoice& choice);
std::string to_text(const LevelChoice& choice);  // several lines

}  // namespace lcrig
