// SPDX-License-Identifier: Apache-2.0
// Compares results of runs. An error cancels in the ratio of two results only if both runs prove
// that they share its source; results of unlike runs are converted or refused, with the reason.
// `lcrig analyze`, `lcrig compare` and the report use it. docs/analysis.md, "Comparisons".
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/analysis.hpp"

namespace lcrig {

struct Comparison {
  std::int64_t from_run = 0, to_run = 0;
  std::string from_specimen, to_specimen;
  std::string quantity;  // name of the metric, with its range
  std::optional<double> from_value, to_value;  // after the conversion; absent: the run has none
  std::string refused;  // why the two cannot be compared; empty: they can
  std::string remedy;  // of a refusal: what would make them comparable
  std::string converted;  // how they were made comparable; empty: nothing was necessary
  std::vector<std::string> differences;  // other differences between the runs
  std::vector<std::string> not_included;  // what the interval does not contain: no size is known
  std::vector<std::string> shared, not_shared;  // sources of error; of the latter with the reason
  std::string verdict;  // a sentence that can be quoted
  // Absent if refused.
  std::optional<double> increase_percent, standard_error_percent;
  std::optional<std::array<double, 2>> interval_percent, ratio;  // ratio: interval of to over from

  bool is_answered() const { return refused.empty(); }
  // Refusal, conversion, differences and what is not included, in one line; may be empty.
  std::string remark() const;
  std::string not_included_text() const;  // "not in the interval: open correction"; may be empty
};

// A run again, its pressures over the area of this body. nullopt: that is not possible.
using AnalyseAgain = std::function<std::optional<RunAnalysis>(const RunAnalysis& run, PressureOn on,
                                                              const AnalysisOptions& options)>;

// Compares each run with the run before it and with the first: the sensitivity in every range, C0
// and dynamic range, as far as one of the two runs has it. Empty for fewer than two runs. Without
// `again` nothing can be converted.
std::vector<Comparison> compare(std::span<const RunAnalysis> runs, const AnalyseAgain& again = {});

// The `again` of runs whose rows are still loaded. The data must outlive it.
AnalyseAgain analyses_of(std::vector<const RunData*> runs);

nlohmann::json to_json(const Comparison& comparison);
std::string to_text(const std::vector<Comparison>& comparisons);
// The sentences, one a line.
std::string verdicts_text(const std::vector<Comparison>& comparisons);

}  // namespace lcrig
