// SPDX-License-Identifier: Apache-2.0
// Loads and analyses the runs that a command names, and compares them. For `analyze` and `compare`.
#pragma once

#include <string>
#include <vector>

#include "analysis/comparison.hpp"
#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

struct AnalysedRuns {
  std::vector<RunData> data;
  std::vector<RunAnalysis> analyses;  // in the same order

  std::vector<Comparison> compared() const;
};
// Notes of the analyses say whether the rows are those that were recorded.
Outcome<AnalysedRuns> analyse_runs(const Context& context, const std::vector<std::string>& runs,
                                   const AnalysisOptions& options);

}  // namespace lcrig::cli
