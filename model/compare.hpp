// SPDX-License-Identifier: Apache-2.0
// The paper's numbers beside ours: what `lcrig model compare` prints.
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
  bool reproduced = false;  // within 8 %, what the paper's own numbers scatter by
};

// T1 to T5, each row computed now. A target that no assumption reproduces has rows that say so.
// Errors: bug only.
Result<std::vector<PaperComparison>> compare_with_paper();

// Errors and ambiguities of the paper, each with the correct form.
const std::vector<std::string_view>& paper_errata();

nlohmann::json to_json(const std::vector<PaperComparison>& rows);
std::string to_table(const std::vector<PaperComparison>& rows);

}  // namespace lcrig
