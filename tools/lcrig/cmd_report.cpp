// SPDX-License-Identifier: Apache-2.0
// report: one run, or several beside each other, as an HTML file.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "analysis/report/report.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/output_file.hpp"
#include "tools/lcrig/print_json.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

namespace {

class ReportCommand final : public Command {
 public:
  const char* name() const override { return "report"; }
  const char* summary() const override {
    return "One self-contained HTML file about a run, or comparing several";
  }
  const char* example() const override { return "lcrig report 3 4 5 -o stacks.html"; }
  void declare(ArgumentList& list) override {
    list.words("RUN", runs_, "Numbers, or `last`");
    list.option("-o,--output", output_, "FILE", "The page (default: report-RUN.html)");
    list.option("--csv", csv_, "FILE", "The results as a table too, one row a run");
  }
  Outcome<ExitCode> run(Context& context) override;

 private:
  Outcome<std::vector<ReportRun>> load(const Context& context) const;
  std::string page_name(const std::vector<ReportRun>& runs) const;
  std::vector<std::string> runs_;
  std::string output_, csv_;
};

Outcome<std::vector<ReportRun>> ReportCommand::load(const Context& context) const {
  auto db = open_runs(context);
  if (!db) return tl::unexpected(db.error());
  std::vector<ReportRun> out;
  for (const auto& text : runs_) {
    auto number = named_run(*db, text);
    if (!number) return tl::unexpected(number.error());
    auto run = load_report_run(*db, *number);
    if (!run) {
      return tl::unexpected(Failure(run.error(), fmt::format("lcrig runs show {}", *number)));
    }
    out.push_back(std::move(*run));
  }
  return out;
}

std::string ReportCommand::page_name(const std::vector<ReportRun>& runs) const {
  if (!output_.empty()) return output_;
  std::string name = "report";
  for (const ReportRun& run : runs) name += fmt::format("-{}", run.data.run);
  return name + ".html";
}

Outcome<ExitCode> ReportCommand::run(Context& context) {
  auto runs = load(context);
  if (!runs) return tl::unexpected(runs.error());
  const std::string page = report_html(*runs);
  if (output_ == "-") {
    context.console.out << page;
  } else if (auto written = write_file(page_name(*runs), page); !written) {
    return tl::unexpected(written.error());
  }
  if (!csv_.empty()) {
    auto written = write_file(csv_, [&](int fd) { return write_results_csv(*runs, fd, csv_); });
    if (!written) return tl::unexpected(written.error());
  }
  if (output_ == "-") return kOk;
  if (context.global.json) {
    nlohmann::json out{{"file", page_name(*runs)}, {"bytes", page.size()}};
    out["csv"] = csv_.empty() ? nlohmann::json(nullptr) : nlohmann::json(csv_);
    print_json(context.console.out, out);
  } else {
    fmt::print(context.console.out, "{}\n", page_name(*runs));
    if (!csv_.empty()) fmt::print(context.console.out, "{}\n", csv_);
  }
  return kOk;
}

}  // namespace

std::unique_ptr<Command> make_report_command() {
  return std::make_unique<ReportCommand>();
}

}  // namespace lcrig::cli
