// SPDX-License-Identifier: Apache-2.0
// compare: how the results of runs differ, in sentences that can be quoted.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/lcrig/analysed_runs.hpp"
#include "tools/lcrig/analysis_arguments.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class CompareCommand final : public Command {
 public:
  CompareCommand()
      : Command("compare", "How the results of runs differ, with what the runs prove to share",
                "lcrig compare 3 4") {}
  void declare(ArgumentList& list) override {
    list.words(kRunWord, runs_,
               "Two or more; each is compared with the one before it and with the first", true);
    options_.declare(list);
  }

  Outcome<ExitCode> run(Context& context) override {
    if (runs_.size() < 2) {
      return Failure(kUsage, "lcrig compare: one run, expected two or more",
                     "lcrig compare " + (runs_.empty() ? "" : runs_.front() + " ") + "RUN");
    }
    const auto wanted = options_.read("compare");
    if (!wanted) return wanted.error();
    const auto runs = analyse_runs(context, runs_, *wanted);
    if (!runs) return runs.error();
    const auto comparisons = runs->compared();
    json out = {
        {"pressures", json::array()}, {"comparisons", json::array()}, {"verdicts", json::array()}};
    for (const RunAnalysis& a : runs->analyses) {
      out["pressures"].push_back({{"run", a.run}, {"pressure", to_json(a.pressure)}});
    }
    for (const Comparison& c : comparisons) {
      out["comparisons"].push_back(to_json(c));
      out["verdicts"].push_back(c.verdict);
    }
    const ExitCode shown = show(context, out, [&](std::ostream& to) {
      for (const RunAnalysis& a : runs->analyses) {
        if (const auto words = a.pressure.words(); !words.empty()) {
          to << "run " << a.run << ": " << words << '\n';
        }
      }
      to << to_text(comparisons) << '\n' << verdicts_text(comparisons);
    });
    const bool all = std::ranges::all_of(comparisons, &Comparison::is_answered);
    return all && !comparisons.empty() ? shown : kFailed;
  }

 private:
  std::vector<std::string> runs_;
  AnalysisArguments options_;
};

}  // namespace

const CommandFactory kCompareCommand = make_command<CompareCommand>;

}  // namespace lcrig::cli
