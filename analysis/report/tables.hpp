// SPDX-License-Identifier: Apache-2.0
// The tables and lists of facts of a report. Private to the report. Empty text: nothing to show.
#pragma once

#include <span>
#include <string>

#include "analysis/report/html.hpp"
#include "analysis/report/report.hpp"

namespace lcrig::report {

// tables.cpp
// The value with its expanded uncertainty, confidence and k; without one with its standard error.
Cell quoted(const RunAnalysis& analysis, const Metric& metric);
std::string headline_table(const RunAnalysis& analysis);  // the results that people look for first
std::string metrics_table(const RunAnalysis& analysis);  // with definitions
std::string range_table(const RunAnalysis& analysis);
std::string level_table(const ReportRun& run);  // a row for each point of the curve, with the model
std::string cycle_table(const RunAnalysis& analysis);
std::string hold_table(const RunAnalysis& analysis);
std::string outlier_table(const RunAnalysis& analysis);
std::string uncertainty_tables(const std::vector<Uncertainty>& uncertainties);
// "C0, pF"; of a range "sensitivity 0–30 kPa, fF/kPa".
std::string metric_label(const RunAnalysis& analysis, const Metric& metric);

// provenance.cpp
bool is_simulated(const ReportRun& run);
bool is_replayed(const ReportRun& run);  // a recording, played back through simulated instruments
std::string simulated_mark(std::span<const ReportRun> runs);  // a box; empty: all were measured
std::string status_mark(const ReportRun& run);  // a box, unless the run was a success
std::string notes_list(const ReportRun& run);  // notes of the analysis and of people
std::string answer_table(const ReportRun& run);  // what people answered
std::string event_table(const ReportRun& run);  // events that were not planned
std::string provenance_table(const ReportRun& run);
std::string files(const ReportRun& run);  // specimen, parameters, protocol as stored

// compare_page.cpp: the report of several runs
std::string comparison_page(std::span<const ReportRun> runs);

}  // namespace lcrig::report
