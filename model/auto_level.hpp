// SPDX-License-Identifier: Apache-2.0
// Chooses the cheapest level of the stack model whose estimated error meets a tolerance. The bench,
// `lcrig model curve`, `lcrig model fit` and the plan of a run use it.
#pragma once

#include <functional>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "model/error_estimate.hpp"

namespace lcrig {

// An effect that no level contains, and by how much it would change delta C (or C0).
struct Omission {
  std::string effect;
  double relative_size = 0;
  std::string note;  // how the size was estimated
};

struct LevelChoice {
  LevelSettings settings;
  // relative, of delta C at max_pressure, or at lost_beyond if there is one
  double error_estimate = 0;
  // Finite strain has no solution above this pressure, which is below max_pressure. Values beyond
  // it are extrapolated.
  std::optional<Pressure> lost_beyond;
  std::string reason;
  std::vector<Omission> left_out;
};

// Relative tolerances of delta C, tried in this order. The first is finer than any measurement
// here; the last still allows a comparison.
inline constexpr double kUsefulTolerances[] = {1e-3, 1e-2, 0.1};

// Limit of the time that a search may take. The model has no clock, so the caller lends one. A
// refusal then also says how long the best level would take.
struct SearchTime {
  double seconds = std::numeric_limits<double>::infinity();
  std::function<double()> seconds_now;
};

// Errors: the specimen is wrong; no level meets the tolerance, or none does so within the time. The
// message names the best level and the cost of a finer one.
Result<LevelChoice> choose_level(const Specimen& specimen, double tolerance, Pressure max_pressure,
                                 const std::optional<SearchTime>& patience = std::nullopt);
// The same, but reuses what the estimator has already solved.
Result<LevelChoice> choose_level(ErrorEstimator& estimator, double tolerance, Pressure max_pressure,
                                 const std::optional<SearchTime>& patience = std::nullopt);

// For the run row and `--json`.
nlohmann::json to_json(const LevelChoice& choice);
std::string to_text(const LevelChoice& choice);  // several lines

}  // namespace lcrig
