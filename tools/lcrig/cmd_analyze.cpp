// SPDX-License-Identifier: Apache-2.0
// analyze: the results of runs, with their uncertainty.
#include <nlohmann/json.hpp>

#include "analysis/analysis.hpp"
#include "analysis/analysis_text.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/model_options.hpp"
#include "tools/lcrig/print_json.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class AnalyzeCommand final : public Command {
 public:
  const char* name() const override { return "analyze"; }
  const char* summary() const override {
    return "Sensitivity, dynamic range, hysteresis, creep of runs, with their uncertainty";
  }
  const char* example() const override { return "lcrig analyze last"; }
  void declare(ArgumentList& list) override {
    list.words("RUN", runs_, "Numbers, or `last`; several are compared");
    list.options("--range", ranges_, "FROM:TO",
                 "Range of pressure in kPa for a sensitivity (default: 0:30 and 35:100)");
    list.flag("--regions", regions_, "Look for the two linear regions of the curve, too");
    list.option("--confidence", confidence_, "P", "Of the intervals (0.95)");
    list.option("--force-class", force_class_, "PERCENT",
                "Limits of the load cell, percent of reading (assumed: 1)");
    list.option("--certified-from-N", certified_, "N", "Lowest certified force of the load cell");
    list.option("--probe-tolerance-mm", tolerance_, "MM",
                "Limits of the probe's diameter (assumed: 0.02)");
    list.option("--temperature-C", temperature_, "C", "Of the meter (assumed: 23)");
    list.flag("--interpolated-correction", interpolated_,
              "Open and short were not measured at the test frequency itself");
  }
  Outcome<ExitCode> run(Context& context) override;

 private:
  Outcome<AnalysisOptions> options() const;
  Outcome<std::vector<RunAnalysis>> analyse_all(const Context& context) const;

  std::vector<std::string> runs_, ranges_;
  std::string confidence_, force_class_, certified_, tolerance_, temperature_;
  bool regions_ = false, interpolated_ = false;
};

constexpr const char* kHelp = "lcrig analyze --help";

Outcome<double> number(const char* name, const std::string& text) {
  auto value = parse_number(name, text);
  if (value) return *value;
  return tl::unexpected(
      Failure(kUsage, std::string(name) + " \"" + text + "\": expected a number", kHelp));
}

Outcome<PressureRange> parse_range(const std::string& text) {
  const auto colon = text.find(':');
  if (colon == std::string::npos) {
    return tl::unexpected(
        Failure(kUsage, "--range " + text + ": expected FROM:TO in kPa", "--range 0:30"));
  }
  auto from = number("--range", text.substr(0, colon));
  if (!from) return tl::unexpected(from.error());
  auto to = number("--range", text.substr(colon + 1));
  if (!to) return tl::unexpected(to.error());
  return PressureRange{*from, *to};
}

// An option that was given; others leave `out` as it is.
template <class T>
Outcome<ExitCode> take(const char* name, const std::string& text, T& out) {
  if (text.empty()) return kOk;
  auto value = number(name, text);
  if (!value) return tl::unexpected(value.error());
  out = *value;
  return kOk;
}

Outcome<AnalysisOptions> AnalyzeCommand::options() const {
  AnalysisOptions out;
  if (!ranges_.empty()) out.ranges.clear();
  for (const auto& text : ranges_) {
    auto range = parse_range(text);
    if (!range) return tl::unexpected(range.error());
    out.ranges.push_back(*range);
  }
  out.search_regions = regions_;
  out.rig.meter.interpolated_correction = interpolated_;
  for (const auto& taken :
       {take("--confidence", confidence_, out.confidence),
        take("--force-class", force_class_, out.rig.force_class_percent),
        take("--certified-from-N", certified_, out.rig.force_certified_from_N),
        take("--probe-tolerance-mm", tolerance_, out.rig.probe_diameter_tolerance_mm),
        take("--temperature-C", temperature_, out.rig.meter.temperature_C)}) {
    if (!taken) return tl::unexpected(taken.error());
  }
  return out;
}

Outcome<std::vector<RunAnalysis>> AnalyzeCommand::analyse_all(const Context& context) const {
  auto wanted = options();
  if (!wanted) return tl::unexpected(wanted.error());
  auto db = open_runs(context);
  if (!db) return tl::unexpected(db.error());
  std::vector<RunAnalysis> out;
  for (const auto& text : runs_) {
    auto run = named_run(*db, text);
    if (!run) return tl::unexpected(run.error());
    auto analysis = analyse(*db, *run, *wanted);
    if (!analysis) return tl::unexpected(Failure(analysis.error(), "lcrig runs show " + text));
    out.push_back(std::move(*analysis));
  }
  return out;
}

Outcome<ExitCode> AnalyzeCommand::run(Context& context) {
  auto analyses = analyse_all(context);
  if (!analyses) return tl::unexpected(analyses.error());
  const auto comparisons = compare(*analyses);
  if (!context.global.json) {
    for (const RunAnalysis& a : *analyses) context.console.out << to_text(a) << '\n';
    if (!comparisons.empty()) context.console.out << to_text(comparisons);
    return kOk;
  }
  if (analyses->size() == 1) {
    print_json(context.console.out, to_json(analyses->front()));
    return kOk;
  }
  json out = {{"runs", json::array()}, {"comparisons", json::array()}};
  for (const RunAnalysis& a : *analyses) out["runs"].push_back(to_json(a));
  for (const Comparison& c : comparisons) out["comparisons"].push_back(to_json(c));
  print_json(context.console.out, out);
  return kOk;
}

}  // namespace

std::unique_ptr<Command> make_analyze_command() {
  return std::make_unique<AnalyzeCommand>();
}

}  // namespace lcrig::cli
