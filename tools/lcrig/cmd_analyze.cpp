// SPDX-License-Identifier: Apache-2.0
// analyze: the results of runs, with their uncertainty.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "analysis/analysis.hpp"
#include "analysis/analysis_text.hpp"
#include "base/force_class.hpp"
#include "storage/chain.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/model_options.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

Outcome<PressureRange> parse_range(const std::string& text) {
  const auto colon = text.find(':');
  if (colon == std::string::npos) {
    return Failure(kUsage, "--range " + text + ": expected FROM:TO in kPa",
                   "give both ends, such as 0:30 or 35:100");
  }
  auto from = parse_number("--range", text.substr(0, colon));
  if (!from) return from.error();
  auto to = parse_number("--range", text.substr(colon + 1));
  if (!to) return to.error();
  if (*from >= *to) {
    return Failure(kUsage, "--range " + text + ": expected FROM below TO, in kPa",
                   *from > *to ? fmt::format("the lower end first: --range {}:{}",
                                             text.substr(colon + 1), text.substr(0, colon))
                               : "give two pressures");
  }
  return PressureRange{*from, *to};
}

class AnalyzeCommand final : public Command {
 public:
  AnalyzeCommand()
      : Command("analyze",
                "Sensitivity, dynamic range, hysteresis, creep of runs, with their uncertainty",
                "lcrig analyze last") {}
  void declare(ArgumentList& list) override {
    list.words(kRunWord, runs_, "Numbers, uuids, or `last` (default); several are compared");
    list.options("--range", ranges_, "FROM:TO",
                 "Range of pressure in kPa for a sensitivity (default: 0:30 and 35:100)");
    list.flag("--regions", wanted_.search_regions,
              "Look for the two linear regions of the curve, too");
    const auto confidence = fmt::format("Of the intervals ({})", kConfidence);
    list.number("--confidence", wanted_.confidence, "P", confidence.c_str());
    list.number("--force-class", wanted_.rig.force_class_percent, "PERCENT",
                "Of the load cell: 0.5, 1, 2 or 3 percent of reading, ISO 7500-1 (assumed: 1)");
    list.number("--certified-from-N", wanted_.rig.force_certified_from_N, "N",
                "Lowest certified force of the load cell");
    list.number("--probe-tolerance-mm", wanted_.rig.probe_diameter_tolerance_mm, "MM",
                "Limits of the probe's diameter (assumed: 0.02)");
    list.number("--temperature-C", wanted_.rig.meter.temperature_C, "C",
                "Of the meter (assumed: 23)");
    list.flag("--interpolated-correction", wanted_.rig.meter.interpolated_correction,
              "Open and short were not measured at the test frequency itself");
  }

  Outcome<ExitCode> run(Context& context) override {
    if (auto possible = check_options(); !possible) return possible.error();
    auto analyses = analyse_all(context);
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
  Outcome<void> check_options() const {
    const auto& rig = wanted_.rig;
    // A command can be proposed only for a percentage that should have been a fraction. The other
    // values are facts of the rig.
    const auto bad = [](const char* option, double value, const std::string& expected,
                        const std::string& next = "lcrig analyze --help") {
      return Failure(kUsage, fmt::format("{} {:g}: expected {}", option, value, expected), next);
    };
    if (const double p = wanted_.confidence; !(p > 0 && p < 1)) {
      const bool percent = p > 1 && p < 100;
      return bad("--confidence", p, "a share between 0 and 1",
                 percent ? fmt::format("{:g} % is --confidence {:g}", p, p / 100)
                         : "lcrig analyze --help");
    }
    if (rig.force_class_percent && !is_force_class(*rig.force_class_percent)) {
      return bad("--force-class", *rig.force_class_percent, kForceClassWords);
    }
    if (rig.force_certified_from_N && *rig.force_certified_from_N < 0) {
      return bad("--certified-from-N", *rig.force_certified_from_N, "a force from 0 on");
    }
    if (rig.probe_diameter_tolerance_mm && *rig.probe_diameter_tolerance_mm < 0) {
      return bad("--probe-tolerance-mm", *rig.probe_diameter_tolerance_mm, "a length from 0 on");
    }
    return {};
  }

  Outcome<std::vector<RunAnalysis>> analyse_all(const Context& context) {
    if (!ranges_.empty()) wanted_.ranges.clear();
    for (const auto& text : ranges_) {
      auto range = parse_range(text);
      if (!range) return range.error();
      wanted_.ranges.push_back(*range);
    }
    auto db = open_runs(context);
    if (!db) return db.error();
    std::vector<RunAnalysis> out;
    for (const auto& text : runs_) {
      auto run = named_run(context, *db, text);
      if (!run) return run.error();
      auto checked = verify_aside(*db, *run);
      auto analysis = analyse(*db, *run, wanted_);
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

  std::vector<std::string> runs_{"last"}, ranges_;
  AnalysisOptions wanted_;
};

}  // namespace

const CommandFactory kAnalyzeCommand = make_command<AnalyzeCommand>;

}  // namespace lcrig::cli
