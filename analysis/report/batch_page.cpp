// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "analysis/analysis_text.hpp"
#include "analysis/report/batch.hpp"
#include "analysis/report/figures.hpp"
#include "analysis/report/html.hpp"
#include "analysis/report/tables.hpp"
#include "base/iso_time.hpp"

namespace lcrig {

namespace report {

namespace {

std::string group_name(const BatchGroup& group) {
  const std::string parameters = group.parameters_json == "{}" ? "" : " " + group.parameters_json;
  return fmt::format("{}, {}{}", group.specimen, group.protocol, parameters);
}

// Adds the estimands to the label, so that a reader sees when runs measured different slopes.
std::string label_with_estimands(const BetweenRuns& q) {
  std::string out = text(q.label);
  for (const std::string& estimand : q.estimands) out += estimand_line(estimand);
  return out;
}

std::string between_table(const BatchGroup& group, double confidence) {
  Table table{"result",
              "runs",
              "mean",
              "scatter between runs",
              fmt::format("{:g} % interval of the mean", confidence * 100),
              "standard error of one run"};
  for (const BetweenRuns& q : group.quantities) {
    const auto& spread = q.scatter ? q.scatter : q.within;
    table.row({label_with_estimands(q), number(static_cast<std::int64_t>(q.runs)),
               number(q.mean, spread), number(q.scatter), interval(q.interval, spread),
               number(q.within)});
  }
  return table.empty() ? std::string() : table.html();
}

std::string run_number(const BatchedResult& result) {
  return result.listing.runs.empty() ? "–" : std::to_string(result.listing.runs.back());
}

// A table with one row for each run. It has the results that people look for first.
std::string run_table(const BatchGroup& group) {
  const auto with_run = std::ranges::find_if(
      group.results, [](const BatchedResult* r) { return r->run.has_value(); });
  if (with_run == group.results.end()) return {};
  const RunAnalysis& first = (*with_run)->run->analysis;
  std::vector<std::string> heads{"run",      "repeat", "position",
                                 "ended as", "C0, pF", "drift of C0, fF/h"};
  for (const RangeResult& r : first.ranges) {
    heads.push_back(metric_label(first, r.sensitivity));
  }
  heads.emplace_back("dynamic range, %");
  Table table(heads);
  for (const BatchedResult* result : group.results) {
    if (!result->run) continue;
    const RunAnalysis& a = result->run->analysis;
    const auto cell = [](const Metric& m) { return m ? measured(m) : no_number(); };
    std::vector<Cell> cells{
        run_number(*result),
        number(result->listing.repeat),
        number(result->listing.position),
        std::string(to_string(result->run->data.listing.exit_status, "still going on")),
        cell(a.c0),
        cell(a.drift)};
    for (const RangeResult& r : a.ranges) cells.push_back(cell(r.sensitivity));
    cells.push_back(cell(a.dynamic_range));
    table.row(cells);
  }
  return table.html();
}

std::string group_section(const BatchGroup& group, double confidence) {
  std::vector<ReportRun> runs;
  for (const BatchedResult* result : group.results) {
    if (result->run) runs.push_back(*result->run);
  }
  std::string out = between_table(group, confidence) + run_table(group);
  if (!runs.empty()) out += overlay_figure(runs);
  return out;
}

std::string failures(const BatchReport& report) {
  Table table{"entry", "line", "repeat", "specimen", "protocol", "run", "what"};
  for (const BatchedResult& result : report.results) {
    if (result.counts()) continue;
    const BatchListing& l = result.listing;
    const std::string what =
        result.run ? fmt::format("{}: {}",
                                 to_string(result.run->data.listing.exit_status, "still going on"),
                                 result.run->data.listing.reason)
                   : result.no_run;
    table.row({number(l.entry), number(l.line), number(l.repeat), text(l.specimen_name),
               text(l.protocol_name), run_number(result), text(what)});
  }
  return table.empty() ? paragraph("All runs ended well.") : table.html();
}

std::string simulated_box(const BatchReport& report) {
  std::vector<ReportRun> runs;
  for (const BatchedResult& result : report.results) {
    if (result.run) runs.push_back(*result.run);
  }
  return runs.empty() ? std::string() : simulated_mark(runs);
}

}  // namespace

}  // namespace report

std::string batch_report_html(const BatchReport& report) {
  using namespace report;
  const StoredBatch& batch = report.batch;
  const auto good = std::ranges::count_if(report.results, &BatchedResult::counts);
  const std::string title = "Batch " + batch.name;
  std::string body = "<h1>" + text(title) + "</h1>\n";
  body += paragraph(
      fmt::format("{} of {} runs ended well; {}, {}; queued {} by {}", good, report.results.size(),
                  text(batch.file_name), order_words(batch.order, batch.seed.value_or(0)),
                  iso_time(batch.added_unix_ns), text(batch.added_by)),
      "lead");
  body += simulated_box(report);
  body += section("failures", "Failures", failures(report));
  body +=
      paragraph(fmt::format("Standard error of one run: {}. Interval of the mean: what the mean "
                            "of many such runs would be.",
                            kOfScatter),
                "small");
  std::size_t n = 0;
  for (const BatchGroup& group : report.groups) {
    body += section(fmt::format("group-{}", ++n), text(group_name(group)),
                    group_section(group, report.confidence));
  }
  return page(title, body);
}

}  // namespace lcrig
