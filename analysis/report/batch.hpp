// SPDX-License-Identifier: Apache-2.0
// Compares the runs of a batch, for `lcrig report --batch`. Runs of one specimen under one protocol
// are repeats; the page shows their mean and scatter. docs/report.md describes it.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/report/report.hpp"
#include "storage/batches.hpp"

namespace lcrig {

// An entry of a batch with the run that counts for it: the last one.
struct BatchedResult {
  BatchListing listing;
  std::optional<ReportRun> run;  // without its readings; absent: there is nothing to analyse
  std::string no_run;  // why `run` is absent
  bool counts() const;  // the run ended well, so means and scatters include it
};

// One result of several runs that ought to agree.
struct BetweenRuns {
  std::string label;  // "sensitivity 0–30 kPa, fF/kPa"
  std::vector<std::string> estimands;  // branch and time; if several, the runs differ in them
  std::size_t runs = 0;  // number of runs that have this result
  double mean = 0;
  std::optional<double> scatter;  // standard deviation between runs; needs two of them
  std::optional<std::array<double, 2>> interval;  // of the mean
  std::optional<double> within;  // root mean square of the runs' own standard errors
};

struct BatchGroup {
  std::string specimen, protocol, parameters_json;
  std::vector<const BatchedResult*> results;  // in the order of the batch
  std::vector<BetweenRuns> quantities;
};

struct BatchReport {
  StoredBatch batch;
  double confidence = kConfidence;
  std::vector<BatchedResult> results;
  std::vector<BatchGroup> groups;  // in the order of their first row; they point into `results`
};

// Errors: invalid_request (no such batch; the message names those that exist), unreadable database.
Result<BatchReport> load_batch_report(const Database& db, std::string_view name,
                                      const AnalysisOptions& options = {});
std::string batch_report_html(const BatchReport& report);
nlohmann::json to_json(const BatchReport& report);

// Mean, scatter and t interval, with equal weights. Runs without the result are not in `values`.
BetweenRuns between_runs(const std::vector<Estimate>& values, double confidence);

}  // namespace lcrig
