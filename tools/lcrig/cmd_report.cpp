// SPDX-License-Identifier: Apache-2.0
// report: one run, or several beside each other, as an HTML file.
#include <fmt/ostream.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "analysis/report/batch.hpp"
#include "analysis/report/report.hpp"
#include "base/strict_json.hpp"
#include "base/text.hpp"
#include "tools/lcrig/analysis_arguments.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/output_file.hpp"
#include "tools/lcrig/run_database.hpp"
#include "tools/lcrig/watch_picture.hpp"

namespace lcrig::cli {

namespace {

class ReportCommand final : public Command {
 public:
  ReportCommand()
      : Command("report", "One self-contained HTML file about a run, or comparing several",
                "lcrig report 3 4 5 -o stacks.html") {}
  void declare(ArgumentList& list) override {
    list.words(kRunWord, runs_, "Numbers, uuids, or `last` (default)");
    list.option("-o,--output", output_, kFileWord, "The page (default: report-RUN.html)");
    list.option("--csv", csv_, kFileWord, "The results as a table too, one row a run");
    list.option("--batch", batch_, {"NAME", Proposes::batch},
                "Compare the runs of a batch instead");
    options_.declare(list);
  }

  Outcome<ExitCode> run(Context& context) override {
    if (auto fits = check_output(); !fits) return fits.error();
    const auto wanted = options_.read("report");
    if (!wanted) return wanted.error();
    if (!batch_.empty()) return report_batch(context, *wanted);
    auto runs = load(context, *wanted);
    if (!runs) return runs.error();
    const std::string file = page_name(*runs);
    if (auto fits = check_files(file); !fits) return fits.error();
    if (auto fits = check_runs(file, *runs); !fits) return fits.error();
    const std::string page = report_html(*runs);
    if (output_ == "-") {
      context.console.out << page;
    } else if (auto written = write_file(file, kPageMark, page); !written) {
      return written.error();
    }
    if (!csv_.empty()) {
      const auto table = [&](int fd) { return write_results_csv(*runs, fd, csv_); };
      auto written = write_file(csv_, kTableMark, table);
      if (!written) return written.error();
    }
    if (output_ == "-") return kOk;
    nlohmann::json files{{"file", file}, {"bytes", page.size()}};
    files["csv"] = csv_.empty() ? nlohmann::json(nullptr) : nlohmann::json(csv_);
    return show(context, files, [&](std::ostream& out) {
      fmt::print(out, "{}\n", file);
      if (!csv_.empty()) fmt::print(out, "{}\n", csv_);
    });
  }

 private:
  // Refuses the ending of another format, because somebody would pass the page on as such a file.
  Outcome<bool> check_output() const {
    const std::string ending = std::filesystem::path(output_).extension().string();
    for (const char* other : {".pdf", ".csv", ".json", ".png", ".svg", ".txt", ".docx", ".md"}) {
      if (ending != other) continue;
      const char* how = ending == ".pdf"   ? "; a browser prints it as one"
                        : ending == ".csv" ? "; --csv FILE writes the results as a table"
                                           : "";
      return Failure(kUsage,
                     fmt::format("lcrig report: -o {}: the page is HTML, no {}{}",
                                 printable(output_, kLongestName), ending.substr(1), how),
                     "lcrig report -o report.html");
    }
    return true;
  }

  // Refuses one name for both outputs, before the first of them is written.
  Outcome<bool> check_files(const std::string& page) const {
    if (!csv_.empty() && page != "-" && is_same_file(page, csv_)) {
      return Failure(kUsage,
                     fmt::format("lcrig report: the page and --csv are one file, {}",
                                 printable(csv_, kLongestName)),
                     "give two names: -o report.html --csv report.csv");
    }
    if (page != "-") {
      if (auto fits = require_replaceable(page, kPageMark); !fits) return fits.error();
    }
    if (auto fits = require_replaceable(csv_, kTableMark); !fits) return fits.error();
    return true;
  }

  // Refuses to replace a report of another database. The default name has only the number of the
  // run, and another database may have a run with the same number.
  Outcome<bool> check_runs(const std::string& page, const std::vector<ReportRun>& runs) const {
    std::error_code unknown;
    if (!output_.empty() || std::filesystem::file_size(page, unknown) == 0 || unknown) return true;
    const auto text = read_text_file(page);
    if (!text) return Failure(text.error(), "give another name: -o FILE");
    for (const ReportRun& run : runs) {
      if (text->find(run.data.row.uuid) != text->npos) continue;
      return Failure(kFailed, fmt::format("{} is about another run", page),
                     fmt::format("give another name: -o {}-new.html",
                                 std::filesystem::path(page).stem().string()));
    }
    return true;
  }

  Outcome<ExitCode> report_batch(Context& context, const AnalysisOptions& wanted) const {
    if (runs_ != std::vector<std::string>{"last"} || !csv_.empty()) {
      return Failure(kUsage, "lcrig report: --batch takes neither RUN nor --csv",
                     "lcrig report --help");
    }
    auto db = open_runs(context);
    if (!db) return db.error();
    auto report = load_batch_report(*db, batch_, wanted);
    if (!report) {
      return Failure(report.error(), "give a --batch that is there, or another --db");
    }
    const std::string page = batch_report_html(*report);
    if (output_ == "-") {
      context.console.out << page;
      return kOk;
    }
    const std::string file = output_.empty() ? batch_file() : output_;
    if (auto written = write_file(file, kPageMark, page); !written) return written.error();
    nlohmann::json all = to_json(*report);
    all["file"] = file;
    return show(context, all, [&](std::ostream& out) { fmt::print(out, "{}\n", file); });
  }

  // The name of a batch may contain characters that a file name cannot.
  std::string batch_file() const {
    std::string out = "report-" + batch_ + ".html";
    std::ranges::replace(out, '/', '_');
    return out;
  }

  Outcome<std::vector<ReportRun>> load(const Context& context,
                                       const AnalysisOptions& wanted) const {
    auto db = open_runs(context);
    if (!db) return db.error();
    std::vector<ReportRun> out;
    for (const auto& text : runs_) {
      auto number = named_run(context, *db, text);
      if (!number) return number.error();
      auto run = load_report_run(*db, *number, wanted);
      if (!run) {
        return Failure(run.error(),
                       next_command(context.global, {"runs", "show", std::to_string(*number)}));
      }
      if (runs_.size() == 1) run->watch = watch_picture(*db, *number);
      out.push_back(std::move(*run));
    }
    return out;
  }

  std::string page_name(const std::vector<ReportRun>& runs) const {
    if (!output_.empty()) return output_;
    std::string page = "report";
    for (const ReportRun& run : runs) page += fmt::format("-{}", run.data.run);
    return page + ".html";
  }

  std::vector<std::string> runs_{"last"};
  std::string output_, csv_, batch_;
  AnalysisArguments options_;
};

}  // namespace

const CommandFactory kReportCommand = make_command<ReportCommand>;

}  // namespace lcrig::cli
