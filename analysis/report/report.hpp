// SPDX-License-Identifier: Apache-2.0
// Shows a run, or several beside each other, as one HTML file that needs nothing else, for `lcrig
// report`. docs/report.md describes it.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/analysis.hpp"
#include "storage/chain.hpp"

namespace lcrig {

// The model's curve for the specimen of the run.
struct ModelledCurve {
  std::string level;
  // Relative, of delta C at the largest pressure; absent: not known.
  std::optional<double> error_estimate;
  std::string note;  // the choice, and what was assumed
  std::vector<double> delta_C_fF;  // at the points of RunAnalysis::curve, in their order
  std::vector<double> peak_delta_C_fF;  // at the peaks of RunAnalysis::cycles; no pressures: empty
  // The same over the whole range of pressures, for the picture.
  std::vector<double> pressure_kPa, smooth_delta_C_fF;
};

struct ReportRun {
  RunData data;
  RunAnalysis analysis;
  ChainReport chain;
  std::vector<RunNote> notes;
  std::optional<ModelledCurve> model;
  std::string no_model;  // why `model` is absent
};

// Reads one run, checks its hash chain, evaluates the model of its specimen. Errors: those of
// load_run_data and analyse. A specimen that the model cannot compute is no error.
Result<ReportRun> load_report_run(const Database& db, std::int64_t run,
                                  const AnalysisOptions& options = {});

// One run: everything about it. Several: a comparison. At least one.
std::string report_html(std::span<const ReportRun> runs);

// The results table, one row a run, to an open file; `name` stands in messages.
Result<> write_results_csv(std::span<const ReportRun> runs, int fd, const std::string& name);

}  // namespace lcrig
