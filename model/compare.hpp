// SPDX-License-Identifier: Apache-2.0
// The paper's numbers beside ours. `lcrig model compare` prints them.
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
  std::string assumption;  // under which the model gives this number
  bool reproduced = false;  // within 8 %, which is how far the paper's own numbers scatter
};

// T1 to T5, each row computed now. If no assumption reproduces a target, its rows say so. Errors:
// bug only.
Result<std::vector<PaperComparison>> compare_with_paper();

// Errors and ambiguities of the paper, each with the correct form.
const std::vector<std::string_view>& paper_errata();

nlohmann::json to_json(const std::vector<PaperComparison>& rows);
std::string to_table(const std::vector<PaperComparison>& rows);

}  // namespace lcrig
