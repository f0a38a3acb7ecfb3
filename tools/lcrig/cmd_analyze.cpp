// SPDX-License-Identifier: Apache-2.0
// analyze: the results of runs, with their uncertainty.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "analysis/analysis.hpp"
#include "analysis/analysis_text.hpp"
#include "tools/lcrig/analysed_runs.hpp"
#include "tools/lcrig/analysis_arguments.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class AnalyzeCommand final : public Command {
 public:
  AnalyzeCommand()
      : Command("analyze",
                "Sensitivity, dynamic range, hysteresis, creep of runs, with their uncertainty",
                "lcrig analyze last") {}
  void declare(ArgumentList& list) override {
    list.words(kRunWord, runs_, "Numbers, uuids, or `last` (default); several are compared");
    options_.declare(list);
  }

  Outcome<ExitCode> run(Context& context) override {
    const auto wanted = options_.read("analyze");
    if (!wanted) return wanted.error();
    const auto analysed = analyse_runs(context, runs_, *wanted);
    if (!analysed) return analysed.error();
    const auto& analyses = analysed->analyses;
    const auto comparisons = analysed->compared();
    json out = {{"runs", json::array()}, {"comparisons", json::array()}};
    for (const RunAnalysis& a : analyses) out["runs"].push_back(to_json(a));
    for (const Comparison& c : comparisons) out["comparisons"].push_back(to_json(c));
    return show(context, analyses.size() == 1 ? out["runs"][0] : out, [&](std::ostream& to) {
      for (const RunAnalysis& a : analyses) to << to_text(a) << '\n';
      if (!comparisons.empty()) to << to_text(comparisons);
    });
  }

 private:
  std::vector<std::string> runs_{"last"};
  AnalysisArguments options_;
};

}  // namespace

const CommandFactory kAnalyzeCommand = make_command<AnalyzeCommand>;

}  // namespace lcrig::cli
