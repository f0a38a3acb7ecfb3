// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/analysis_arguments.hpp"

#include <fmt/format.h>

#include "base/force_class.hpp"
#include "tools/lcrig/model_options.hpp"

namespace lcrig::cli {

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

// Facts of the rig that cannot be negative.
struct StatedFact {
  const char* option;
  std::optional<double> value;
  const char* expected;
};

Outcome<void> check_stated(const AnalysisOptions& wanted, const std::string& help) {
  const auto& rig = wanted.rig;
  // A command can be proposed only for a percentage that should have been a fraction. The other
  // values are facts of the rig.
  const auto bad = [](const char* option, double value, const std::string& expected,
                      const std::string& next) {
    return Failure(kUsage, fmt::format("{} {:g}: expected {}", option, value, expected), next);
  };
  if (const double p = wanted.confidence; !(p > 0 && p < 1)) {
    const bool percent = p > 1 && p < 100;
    return bad("--confidence", p, "a share between 0 and 1",
               percent ? fmt::format("{:g} % is --confidence {:g}", p, p / 100) : help);
  }
  if (rig.force_class_percent && !is_force_class(*rig.force_class_percent)) {
    return bad("--force-class", *rig.force_class_percent, kForceClassWords, help);
  }
  const StatedFact facts[] = {
      {"--certified-from-N", rig.force_certified_from_N, "a force from 0 on"},
      {"--probe-tolerance-mm", rig.probe_diameter_tolerance_mm, "a length from 0 on"},
      {"--stray-limit-fF", rig.stray_limit_fF, "a capacitance from 0 on"},
      {"--leads-m", rig.meter.cable_m, "a length from 0 on"}};
  for (const StatedFact& fact : facts) {
    if (fact.value && *fact.value < 0) return bad(fact.option, *fact.value, fact.expected, help);
  }
  return {};
}

}  // namespace

void AnalysisArguments::declare(ArgumentList& list) {
  list.options("--range", ranges_, "FROM:TO",
               "Range of pressure in kPa for a sensitivity (default: 0:30 and 35:100)");
  list.flag("--regions", wanted_.search_regions,
            "Look for the two linear regions of the curve, too");
  const auto confidence = fmt::format("Of the intervals ({})", kConfidence);
  list.number("--confidence", wanted_.confidence, "P", confidence.c_str());
  list.number("--force-class", wanted_.rig.force_class_percent, "PERCENT",
              "Of the load cell: 0.5, 1, 2 or 3 percent of reading, ISO 7500-1 (default: as "
              "recorded, else 1 is assumed)");
  list.number("--certified-from-N", wanted_.rig.force_certified_from_N, "N",
              "Lowest certified force of the load cell");
  list.number("--probe-tolerance-mm", wanted_.rig.probe_diameter_tolerance_mm, "MM",
              "Limits of the probe's diameter (assumed: 0.02)");
  list.number("--stray-limit-fF", wanted_.rig.stray_limit_fF, "FF",
              "Limit of the capacitance of leads and fixture, for a run without open correction");
  list.number("--temperature-C", wanted_.rig.meter.temperature_C, "C",
              "Of the meter (assumed: 23)");
  list.number("--leads-m", wanted_.rig.meter.cable_m, "M", "Length of the leads (assumed: 0)");
  list.flag("--interpolated-correction", wanted_.rig.meter.interpolated_correction,
            "Open and short were not measured at the test frequency itself");
}

Outcome<AnalysisOptions> AnalysisArguments::read(const std::string& command) const {
  AnalysisOptions out = wanted_;
  if (auto possible = check_stated(out, "lcrig " + command + " --help"); !possible) {
    return possible.error();
  }
  if (!ranges_.empty()) out.ranges.clear();
  for (const auto& text : ranges_) {
    auto range = parse_range(text);
    if (!range) return range.error();
    out.ranges.push_back(*range);
  }
  return out;
}

}  // namespace lcrig::cli
