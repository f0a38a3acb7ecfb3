// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "analysis/csv.hpp"
#include "analysis/report/report.hpp"
#include "base/decimal.hpp"

namespace lcrig {

namespace {

// For a range, such as "sensitivity_fF_per_kPa", the name of the column also gives the range.
std::string column_name(const RunAnalysis& analysis, const Metric& metric) {
  for (const RangeResult& r : analysis.ranges) {
    if (&r.sensitivity != &metric) continue;
    return fmt::format("sensitivity_{:g}_to_{:g}_kPa_fF_per_kPa", r.range.from_kPa, r.range.to_kPa);
  }
  return metric.name;
}

// Metrics outside the ranges that may have an expanded uncertainty.
bool has_own_column(const RunAnalysis& a, const Metric& metric) {
  const Metric* const known[] = {&a.c0, &a.delta_C, &a.dynamic_range, &a.force_sensitivity,
                                 &a.hysteresis.largest_gap};
  return std::ranges::find(known, &metric) != std::end(known);
}

// With a name here, the expanded uncertainty is a lower limit.
std::string not_included(const Uncertainty* u) {
  return u == nullptr ? "" : fmt::format("{}", fmt::join(u->gaps(), "; "));
}

void write_heads(const RunAnalysis& analysis, CsvWriter& out) {
  for (const char* name : {"run", "specimen", "protocol", "simulated", "exit_status",
                           "chain_intact", "fresh_readings"}) {
    out.word(name);
  }
  for (const Metric* metric : analysis.metrics()) {
    const std::string name = column_name(analysis, *metric);
    for (const char* part : {"", "_standard_error", "_interval_low", "_interval_high"}) {
      out.word(name + part);
    }
  }
  for (const RangeResult& r : analysis.ranges) {
    const std::string name = column_name(analysis, r.sensitivity);
    out.word(name + "_expanded_uncertainty");
    out.word(name + "_not_included");
    out.word(name + "_r_squared");
    out.word(name + "_estimand");
  }
  for (const Metric* metric : analysis.chosen()) out.word(metric->name + "_estimand");
  for (const Metric* metric : analysis.metrics()) {
    if (!has_own_column(analysis, *metric)) continue;
    out.word(metric->name + "_expanded_uncertainty");
    out.word(metric->name + "_not_included");
  }
  out.word("confidence");
}

constexpr int kDigits = 9;  // for values without a standard error

// Place of the third digit of the standard error. Digits behind it are noise.
std::optional<int> end_of_digits(const Estimate& e) {
  const auto places = e.standard_error ? decimal_places(*e.standard_error) : std::nullopt;
  return places ? std::optional(places->first - 2) : std::nullopt;
}

void write_number(std::optional<int> end, std::optional<double> value, CsvWriter& out) {
  if (end) {
    out.rounded(value, *end);
  } else {
    out.significant(value, kDigits);
  }
}

void write_run(const ReportRun& run, CsvWriter& out) {
  out.integer(run.data.run);
  out.text(run.data.row.specimen_name);
  out.text(run.data.row.protocol_name);
  out.word(run.data.row.simulated ? "true" : "false");
  out.text(to_string(run.data.listing.exit_status, ""));
  out.word(run.chain.intact ? "true" : "false");
  out.integer(run.data.fresh_readings);
  for (const Metric* metric : run.analysis.metrics()) {
    if (!*metric) {
      for (int i = 0; i < 4; ++i) out.empty();
      continue;
    }
    const Estimate& e = *metric->estimate;
    const auto end = end_of_digits(e);
    write_number(end, e.value, out);
    write_number(end, e.standard_error, out);
    write_number(end, e.interval ? std::optional((*e.interval)[0]) : std::nullopt, out);
    write_number(end, e.interval ? std::optional((*e.interval)[1]) : std::nullopt, out);
  }
  for (const RangeResult& r : run.analysis.ranges) {
    const bool known = !r.uncertainty.parts.empty();
    out.significant(known ? std::optional(r.uncertainty.expanded) : std::nullopt, 3);
    out.text(not_included(&r.uncertainty));
    out.significant(r.r_squared, kDigits);
    out.text(r.sensitivity.estimand);
  }
  for (const Metric* metric : run.analysis.chosen()) out.text(metric->estimand);
  for (const Metric* metric : run.analysis.metrics()) {
    if (!has_own_column(run.analysis, *metric)) continue;
    const Uncertainty* u = run.analysis.uncertainty_of(*metric);
    out.significant(u != nullptr ? std::optional(u->expanded) : std::nullopt, 3);
    out.text(not_included(u));
  }
  out.significant(run.analysis.options.confidence, kDigits);
}

}  // namespace

Result<> write_results_csv(std::span<const ReportRun> runs, int fd, const std::string& name) {
  CsvWriter out(fd, name);
  write_heads(runs.front().analysis, out);
  if (auto ok = out.end_row(); !ok) return ok;
  for (const ReportRun& run : runs) {
    write_run(run, out);
    if (auto ok = out.end_row(); !ok) return ok;
  }
  return out.flush();
}

}  // namespace lcrig
