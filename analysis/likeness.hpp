// SPDX-License-Identifier: Apache-2.0
// Decides in which respects two runs are alike: which sources of error they share, and what forbids
// a comparison of their results. Private to analysis/.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/analysis.hpp"

namespace lcrig {

// Whether two runs share a source of error.
struct SourceLikeness {
  ErrorSource source = ErrorSource::run;
  std::string what;  // "meter LCR-6100 GEZ883880"
  std::string why_not;  // empty: they share it
};
// Of meter, load cell and probe.
std::vector<SourceLikeness> compare_sources(const RunAnalysis& from, const RunAnalysis& to);

// Why two results cannot be compared, and what would make them comparable.
struct Unlike {
  std::string reason, remedy;
};
std::optional<Unlike> unlike_settings(const RunAnalysis& from, const RunAnalysis& to);
// For C0 and what is divided by it, if no limit of the leads' capacitance is known.
std::optional<Unlike> unlike_corrections(const RunAnalysis& from, const RunAnalysis& to);
std::optional<Unlike> unlike_contact(const RunAnalysis& from, const RunAnalysis& to);
// The way of loading and the branch, not the pressures.
std::optional<Unlike> unlike_loading(const LoadState& from, const LoadState& to,
                                     const RunAnalysis& from_run, const RunAnalysis& to_run);
std::optional<Unlike> unlike_peak(const LoadState& from, const LoadState& to,
                                  const RunAnalysis& from_run, const RunAnalysis& to_run);

// What the difference of two times under load may change a ratio by.
struct TimeLikeness {
  std::optional<Unlike> unlike;
  double relative = 0;  // of the result
  double decades = 0;
  bool assumed = false;  // a run does not show its creep
};
TimeLikeness compare_times(const LoadState& from, const LoadState& to, const RunAnalysis& from_run,
                           const RunAnalysis& to_run);

// "simulated", "replayed"; empty: measured.
std::string origin_of(const RunConditions& conditions);

// Other differences that a reader has to know.
std::vector<std::string> name_differences(const RunAnalysis& from, const RunAnalysis& to);

}  // namespace lcrig
