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
using Obstacles = std::vector<Unlike>;  // all that there are, not only the first
Obstacles unlike_settings(const RunAnalysis& from, const RunAnalysis& to);
// For C0 and what is divided by it, if no limit of the leads' capacitance is known.
std::optional<Unlike> unlike_corrections(const RunAnalysis& from, const RunAnalysis& to);
// Equal pressures of the two are equal loads: one body, one probe, one size of disc.
Obstacles unlike_contact(const RunAnalysis& from, const RunAnalysis& to);
// Both load the whole disc, by which runs with other probes or discs become alike.
bool are_alike_over_disc(const RunAnalysis& from, const RunAnalysis& to);
// The way of loading and the branch, not the pressures.
Obstacles unlike_loading(const LoadState& from, const LoadState& to, const RunAnalysis& from_run,
                         const RunAnalysis& to_run);
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

// The disc that only one of the runs records. Empty: both do, or neither.
std::string unknown_disc(const RunAnalysis& from, const RunAnalysis& to);

// Other differences that a reader has to know.
std::vector<std::string> name_differences(const RunAnalysis& from, const RunAnalysis& to);

}  // namespace lcrig
