// SPDX-License-Identifier: Apache-2.0
// analyze: the results of runs, with their uncertainty.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "analysis/analysis.hpp"
#include "analysis/analysis_text.hpp"
#include "storage/chain.hpp"
#include "tools/lcrig/analysis_arguments.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/run_database.hpp"

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
    auto analyses = analyse_all(context, *wanted);
    if (!analyses) return analyses.error();
    const auto comparisons = compare(*analyses);
    json out = {{"runs", json::array()}, {"comparisons", json::array()}};
    for (const RunAnalysis& a : *analyses) out["runs"].push_back(to_json(a));
    for (const Comparison& c : comparisons) out["comparisons"].push_back(to_json(c));
    return show(context, analyses->size() == 1 ? out["runs"][0] : out, [&](std::ostream& to) {
      for (const RunAnalysis& a : *analyses) to << to_text(a) << '\n';
      if (!comparisons.empty()) to << to_text(comparisons);
    });
  }

 private:
  Outcome<std::vector<RunAnalysis>> analyse_all(const Context& context,
                                                const AnalysisOptions& wanted) const {
    auto db = open_runs(context);
    if (!db) return db.error();
    std::vector<RunAnalysis> out;
    for (const auto& text : runs_) {
      auto run = named_run(context, *db, text);
      if (!run) return run.error();
      auto checked = verify_aside(*db, *run);
      auto analysis = analyse(*db, *run, wanted);
      if (!analysis) {
        const auto look = next_command(context.global, {"runs", "show", text});
        return Failure(analysis.error(), next_after(analysis.error(), look));
      }
      const auto chain = checked.get();
      if (!chain) return Failure(chain.error(), next_after(chain.error()));
      if (!chain->intact) analysis->notes.insert(analysis->notes.begin(), remark_on(*chain));
      out.push_back(std::move(*analysis));
    }
    return out;
  }

  std::vector<std::string> runs_{"last"};
  AnalysisArguments options_;
};

}  // namespace

const CommandFactory kAnalyzeCommand = make_command<AnalyzeCommand>;

}  // namespace lcrig::cli
