// SPDX-License-Identifier: Apache-2.0
// Compares the numbers of the paper with those of the model. `lcrig model compare` prints them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace lcrig {

struct PaperComparison {
  std::string target;  // "T2"
  std::string quantity;
  std::string unit;
  double paper = 0, model = 0;
  std::string assumption;  // the assumption under which the model gives this number
  bool reproduced = false;  // within 8 %, the scatter of the paper's own numbers
};

// Computes T1 to T5. If no assumption reproduces a target, its rows say so. Errors: only by a bug.
Result<std::vector<PaperComparison>> compare_with_paper();

// Errors and ambiguities of the paper, each with the corrected form.
const std::vector<std::string_view>& paper_errata();

nlohmann::json to_json(const std::vector<PaperComparison>& rows);
std::string to_table(const std::vector<PaperComparison>& rows);

}  // namespace lcrig
