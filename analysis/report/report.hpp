// SPDX-License-Identifier: Apache-2.0
// Shows one run, or several side by side, as a single HTML file without external parts, for `lcrig
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
  std::string note;  // how the level was chosen, and what was assumed
  std::vector<double> delta_C_fF;  // at the points of RunAnalysis::curve, in their order
  std::vector<double> peak_delta_C_fF;  // at the peaks of RunAnalysis::cycles; no pressures: empty
  // A smooth curve over the whole range of pressures, for the picture.
  std::vector<double> pressure_kPa, smooth_delta_C_fF;
};

// Force against travel of one motion, with the corridor that the watch over the frame judged it by.
struct WatchPicture {
  std::vector<double> travel_mm, force_N, low_N, high_N;  // NaN: no edge
  std::optional<std::size_t> outside;  // the sample in which the watch found something
};

struct ReportRun {
  RunData data;
  RunAnalysis analysis;
  ChainReport chain;
  std::vector<RunNote> notes;
  std::optional<ModelledCurve> model;
  std::string no_model;  // why `model` is absent
  std::optional<WatchPicture> watch;  // absent: the run pressed nothing, or stored no orders
};

// Reads one run, checks its hash chain and evaluates the model of its specimen. Errors: those of
// load_run_data and analyse. A specimen that the model cannot compute is not an error.
Result<ReportRun> load_report_run(const Database& db, std::int64_t run,
                                  const AnalysisOptions& options = {});

// One run gives a full report, several give a comparison. Precondition: at least one run.
std::string report_html(std::span<const ReportRun> runs);

// Writes the table of results, one row for each run, to an open file; messages call it `name`.
Result<> write_results_csv(std::span<const ReportRun> runs, int fd, const std::string& name);

}  // namespace lcrig
