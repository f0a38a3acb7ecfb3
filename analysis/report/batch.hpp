// SPDX-License-Identifier: Apache-2.0
// Compares the runs of a batch, for `lcrig report --batch`: repeats of a specimen under a protocol,
// their mean and how much they scatter. docs/report.md describes the page.
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

// An entry of the batch and the run that counts: the last one.
struct BatchedResult {
  BatchListing listing;
  std::optional<ReportRun> run;  // without its readings; absent: nothing to analyse
  std::string no_run;  // why it is absent
  bool counts() const;  // it ended well: part of means and scatters
};

// One result of several runs that ought to be equal.
struct BetweenRuns {
  std::string label;  // "sensitivity 0–30 kPa, fF/kPa"
  std::vector<std::string> estimands;  // which branch and time; more than one: the runs differ
  std::size_t runs = 0;  // that have it
  double mean = 0;
  std::optional<double> scatter;  // standard deviation between runs; two at least
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
  std::vector<BatchGroup> groups;  // in the order of their first row; points into `results`
};

// Errors: invalid_request (no such batch; it names those that exist), an unreadable database.
Result<BatchReport> load_batch_report(const Database& db, std::string_view name,
                                      const AnalysisOptions& options = {});
std::string batch_report_html(const BatchReport& report);
nlohmann::json to_json(const BatchReport& report);

// Mean, scatter and the t interval of equal weights. Absent runs are not in `values`.
BetweenRuns between_runs(const std::vector<Estimate>& values, double confidence);

}  // namespace lcrig
