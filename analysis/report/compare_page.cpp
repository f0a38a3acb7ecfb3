// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "analysis/comparison.hpp"
#include "analysis/report/figures.hpp"
#include "analysis/report/html.hpp"
#include "analysis/report/tables.hpp"
#include "base/iso_time.hpp"

namespace lcrig::report {

namespace {

std::string simulated_word(const ReportRun& run) {
  return is_simulated(run) ? "<b>simulated</b>" : "measured";
}

// A table with one column for each run.
std::string results_table(std::span<const ReportRun> runs) {
  std::vector<std::string> heads{""};
  for (const ReportRun& run : runs) {
    heads.push_back(fmt::format("run {}<br/>{}", run.data.run, text(run.data.row.specimen_name)));
  }
  Table table(heads);
  const auto row = [&](const std::string& label, auto cell) {
    std::vector<Cell> cells{label};
    for (const ReportRun& run : runs) cells.push_back(cell(run));
    table.row(cells);
  };
  row("protocol", [](const ReportRun& r) { return text(r.data.row.protocol_name); });
  row("origin", simulated_word);
  if (std::ranges::any_of(runs, [](const ReportRun& r) { return r.analysis.pressure.differs(); })) {
    row("pressure", [](const ReportRun& r) { return text(r.analysis.pressure.words()); });
  }
  row("made", [](const ReportRun& r) { return iso_time(true_time_ns(r.data.row)); });
  row("ended as", [](const ReportRun& r) {
    return std::string(to_string(r.data.listing.exit_status, "still going on"));
  });
  const auto reference = runs.front().analysis.metrics();
  for (std::size_t i = 0; i < reference.size(); ++i) {
    bool anywhere = false;
    for (const ReportRun& r : runs) anywhere = anywhere || *r.analysis.metrics().at(i);
    if (!anywhere) continue;
    row(text(metric_label(runs.front().analysis, *reference[i])), [i](const ReportRun& r) {
      const Metric& m = *r.analysis.metrics().at(i);
      return m ? Cell(quoted(r.analysis, m) + estimand_line(m.estimand), Cell::Kind::number)
               : no_number();
    });
  }
  return table.html() + two_truths();
}

std::vector<Comparison> comparisons_of(std::span<const ReportRun> runs) {
  std::vector<RunAnalysis> analyses;
  std::vector<const RunData*> data;
  for (const ReportRun& run : runs) {
    analyses.push_back(run.analysis);
    data.push_back(&run.data);
  }
  return compare(analyses, analyses_of(std::move(data)));
}

// What a reader has to know beside the numbers, one line each.
std::string remarks_on(const Comparison& c) {
  std::string out = estimand_line(c.remark());
  if (!c.remedy.empty()) out += estimand_line("to compare them: " + c.remedy);
  for (const std::string& s : c.not_shared) out += estimand_line("not proven the same: " + s);
  return out;
}

std::string increase_table(std::span<const ReportRun> runs) {
  Table table{"result",
              "from",
              "to",
              "value from",
              "value to",
              "increase",
              "± standard error, %",
              fmt::format("{:g} % interval, %", runs.front().analysis.options.confidence * 100)};
  std::string verdicts;
  for (const Comparison& c : comparisons_of(runs)) {
    const auto se = c.standard_error_percent;
    const auto value = [](const std::optional<double>& v) { return v ? number(*v) : no_number(); };
    table.row({text(c.quantity) + remarks_on(c),
               fmt::format("run {}, {}", c.from_run, text(c.from_specimen)),
               fmt::format("run {}, {}", c.to_run, text(c.to_specimen)), value(c.from_value),
               value(c.to_value), c.increase_percent ? percent(*c.increase_percent) : no_number(),
               se ? number(*se, se) : no_number(), interval(c.interval_percent, se)});
    verdicts += "<li>" + text(c.verdict) + "</li>\n";
  }
  if (table.empty()) return {};
  return paragraph(
             "Each run with the one before it and with the first. An error of meter, load cell or "
             "probe cancels only where both runs prove that they used the same one.") +
         table.html() + "<ul>\n" + verdicts + "</ul>\n";
}

// The texts that `part` makes of each run, under the name of the run.
template <class Part>
std::string each_run(std::span<const ReportRun> runs, Part part) {
  std::string out;
  for (const ReportRun& run : runs) {
    const std::string body = part(run);
    if (!body.empty()) out += "<h3>" + text(run_label(run)) + "</h3>\n" + body;
  }
  return out;
}

void add(std::string& page, std::string_view id, std::string_view title, const std::string& body) {
  if (!body.empty()) page += section(id, title, body);
}

}  // namespace

std::string comparison_page(std::span<const ReportRun> runs) {
  std::string title = "Comparison of runs";
  std::string marks = simulated_mark(runs);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    title += fmt::format("{} {}", i == 0 ? "" : ",", runs[i].data.run);
    marks += status_mark(runs[i]);
  }
  std::string body;
  add(body, "results", "Results", results_table(runs));
  add(body, "increase", "Increase", increase_table(runs));
  add(body, "pressure", "ΔC against pressure", overlay_figure(runs) + side_by_side_figure(runs));
  add(body, "cycles", "ΔC/C0 over the cycles", cycles_side_by_side_figure(runs));
  add(body, "uncertainty", "Uncertainty", each_run(runs, [](const ReportRun& run) {
        return uncertainty_tables(run.analysis.uncertainties);
      }));
  add(body, "events", "Events and gaps", each_run(runs, event_table));
  add(body, "provenance", "Provenance",
      each_run(runs, [](const ReportRun& run) { return notes_list(run) + provenance_table(run); }));
  return page(title, "<h1>" + text(title) + "</h1>\n" + marks + body);
}

}  // namespace lcrig::report
