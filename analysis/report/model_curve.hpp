// SPDX-License-Identifier: Apache-2.0
// The model's answer at measured pressures; knows nothing of the analysis.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace lcrig::report {

struct ModelRequest {
  std::string specimen_text, specimen_name;
  // Only in a simulated run: the level that its bench chose (storage: model_level,
  // model_error_json).
  std::optional<std::string> level, choice_json;
  double probe_area_m2 = 0;
  std::vector<double> pressure_kPa;  // over the probe, any order
};
struct ModelAnswer {
  std::string level, note;
  std::optional<double> error_estimate;
  std::vector<double> delta_C_fF;  // in the order of the request
  std::vector<double> smooth_kPa, smooth_fF;
};
// Errors: the specimen does not parse, no level answers.
Result<ModelAnswer> evaluate_model(const ModelRequest& request);

}  // namespace lcrig::report
