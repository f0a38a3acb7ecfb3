// SPDX-License-Identifier: Apache-2.0
// Computes the model's answer at measured pressures, without the analysis, for the report.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace lcrig::report {

struct ModelRequest {
  std::string specimen_text, specimen_name;
  // For simulated runs only: the level that the bench chose (storage: model_level,
  // model_error_json).
  std::optional<std::string> level, choice_json;
  double area_m2 = 0;  // that the pressures are over
  std::vector<double> pressure_kPa;  // in any order
};
struct ModelAnswer {
  std::string level, note;
  std::optional<double> error_estimate;
  std::vector<double> delta_C_fF;  // in the order of the request
  std::vector<double> smooth_kPa, smooth_fF;
};
// Errors: the specimen cannot be parsed; no level of the model gives an answer.
Result<ModelAnswer> evaluate_model(const ModelRequest& request);

}  // namespace lcrig::report
