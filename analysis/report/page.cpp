// SPDX-License-Identifier: Apache-2.0
// The report of one run.
#include <fmt/format.h>

#include "analysis/report/figures.hpp"
#include "analysis/report/html.hpp"
#include "analysis/report/tables.hpp"
#include "base/iso_time.hpp"

namespace lcrig {

namespace report {

namespace {

// Collects the sections that have content, and links to them from the top of the page.
class Page {
 public:
  void add(std::string_view id, std::string_view title, const std::string& body) {
    if (body.empty()) return;
    links_ += fmt::format("<a href='#{}'>{}</a> ", id, title);
    body_ += section(id, title, body);
  }
  std::string navigation() const { return "<nav>" + links_ + "</nav>\n"; }
  const std::string& body() const { return body_; }

 private:
  std::string links_, body_;
};

std::string titled(const std::string& title, const std::string& body) {
  return body.empty() ? body : "<h3>" + title + "</h3>\n" + body;
}

std::string head_facts(const ReportRun& run) {
  const RunRow& row = run.data.row;
  const auto words = run.analysis.pressure.words();
  return (words.empty() ? words : paragraph(text(words), "lead")) +
         paragraph(fmt::format("{}, {}; operator {}; {:.0f} s; {} readings",
                               text(row.protocol_name), iso_time(true_time_ns(row)),
                               text(row.operator_name.empty() ? "–" : row.operator_name),
                               run.data.duration_s, run.data.fresh_readings),
                   "lead");
}

std::string summary(const ReportRun& run) {
  return headline_table(run.analysis) + two_truths() + notes_list(run);
}

std::string model_section(const ReportRun& run) {
  if (!run.model) return paragraph("No comparison: " + text(run.no_model) + ".");
  const auto error = run.model->error_estimate;
  std::string out = paragraph(fmt::format(
      "Level {}, {}. Its estimated error of ΔC is {}.", text(run.model->level),
      text(run.model->note), error ? plain_number(*error * 100) + " % of the value" : "not known"));
  if (run.data.row.simulated) {
    out += paragraph(
        "The run was simulated with this model: the difference shows the noise and "
        "the errors of the simulated instruments, and nothing about a specimen.");
  }
  return out + model_figure(run) + level_table(run);
}

}  // namespace

std::string run_page(const ReportRun& run) {
  const RunAnalysis& a = run.analysis;
  Page p;
  p.add("results", "Results", summary(run));
  const auto curve = curve_figure(run);
  p.add("pressure", "ΔC against pressure", curve.empty() ? curve : curve + range_table(a));
  p.add("answers", "Answers of people", answer_table(run));
  p.add("time", "C and force over time", time_figure(run));
  p.add("cycles", "ΔC/C0 over the cycles", cycle_figure(run) + cycle_table(a));
  p.add("loops", "Hysteresis", loop_figure(run));
  p.add("holds", "Creep and drift in holds", hold_figure(run) + hold_table(a));
  p.add("model", "Comparison with the model", model_section(run));
  p.add("watch", "What the watch over the frame allowed", watch_figure(run));
  p.add("uncertainty", "Uncertainty", uncertainty_tables(a.uncertainties));
  p.add("metrics", "All results and their definitions", metrics_table(a));
  p.add("events", "Events and gaps", event_table(run) + titled("Outliers", outlier_table(a)));
  p.add("provenance", "Provenance", provenance_table(run) + files(run));
  const std::string title = fmt::format(
      "Run {}: {}, {}", run.data.run,
      run.data.row.specimen_name.empty() ? "unnamed specimen" : run.data.row.specimen_name,
      a.protocol);
  const std::span<const ReportRun> one(&run, 1);
  return page(title, "<h1>" + text(title) + "</h1>\n" + head_facts(run) + simulated_mark(one) +
                         status_mark(run) + p.navigation() + p.body());
}

}  // namespace report

std::string report_html(std::span<const ReportRun> runs) {
  return runs.size() == 1 ? report::run_page(runs.front()) : report::comparison_page(runs);
}

}  // namespace lcrig
