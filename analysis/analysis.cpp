// SPDX-License-Identifier: Apache-2.0
#include "analysis/analysis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/metrics.hpp"

namespace lcrig {

namespace {

Result<> check(const AnalysisOptions& options) {
  for (const PressureRange& r : options.ranges) {
    if (!std::isfinite(r.from_kPa) || !std::isfinite(r.to_kPa) || r.from_kPa >= r.to_kPa) {
      return fail(Errc::invalid_request, "range {}: it must lead from a lower to a higher pressure",
                  range_text(r));
    }
  }
  if (!(options.confidence >= 0.5 && options.confidence < 1)) {
    return fail(Errc::invalid_request, "confidence {}: it must lie between 0.5 and 1",
                options.confidence);
  }
  return {};
}

void add_notes(const RunData& data, RunAnalysis& out) {
  const auto note = [&out](std::string text) { out.notes.push_back(std::move(text)); };
  if (data.row.bench_name.starts_with("replay:")) {
    note("a recording was played back through simulated instruments");
  } else if (data.row.simulated) {
    note("simulated: nothing was measured");
  }
  if (out.exit_status != ExitStatus::success) {
    note(fmt::format("the run ended with {}{}{}", to_string(out.exit_status, "?"),
                     data.listing.reason.empty() ? "" : ": ", data.listing.reason));
  }
  if (data.overloads > 0) note(fmt::format("{} readings are overloads", data.overloads));
  if (data.repeated_readings > 0) {
    note(fmt::format("{} answers repeated the value before and are not used",
                     data.repeated_readings));
  }
  if (data.other_function > 0) {
    note(fmt::format("{} readings of other functions are not used", data.other_function));
  }
  const auto [low, high] = std::minmax_element(
      data.readings.begin(), data.readings.end(),
      [](const RunReading& a, const RunReading& b) { return a.capacitance_F < b.capacitance_F; });
  if (data.readings.size() >= 3 && low->capacitance_F == high->capacitance_F) {
    note("all readings are alike: a meter that measures shows its noise");
  }
  const auto negative = std::count_if(data.readings.begin(), data.readings.end(),
                                      [](const RunReading& r) { return r.capacitance_F < 0; });
  if (negative > 0) {
    note(fmt::format(
        "{} readings of a negative capacitance: look at the open correction and the function",
        negative));
  }
  if (!data.has_frame()) note("no force was recorded");
  if (data.frame_gaps > 0) {
    note(fmt::format("{} gaps in the frame's samples: nothing is interpolated across them",
                     data.frame_gaps));
  }
}

void add_level_notes(const RunData& data, RunAnalysis& out) {
  std::int64_t missing = 0;
  for (const LevelResult& l : out.levels) missing += l.missing;
  if (missing > 0) {
    out.notes.push_back(
        fmt::format("{} planned readings of levels are missing (overload, no force, or the level "
                    "broke off)",
                    missing));
  }
  const auto abandoned = std::count_if(data.levels.begin(), data.levels.end(),
                                       [](const LevelRow& l) { return l.abandoned; });
  if (abandoned > 0) {
    out.notes.push_back(fmt::format(
        "{} levels were abandoned when an instrument was lost in them: left out", abandoned));
  }
  const auto empty = std::ssize(data.levels) - std::ssize(out.levels) - abandoned;
  if (empty > 0 && data.area_m2) {
    out.notes.push_back(fmt::format("{} levels have no usable reading", empty));
  }
  if (out.outlier_count > 0) {
    out.notes.push_back(
        fmt::format("{} outliers among the readings of levels and baseline: listed, and kept in "
                    "every result but "
                    "the robust ones",
                    out.outlier_count));
  }
}

}  // namespace

void calc_limit_of_detection(const Scene& scene, RunAnalysis& out) {
  out.limit_of_detection = metric("limit_of_detection_kPa",
                                  "three standard deviations of one reading over the sensitivity "
                                  "of 0-30 kPa (without it, of the "
                                  "lowest range that was asked for)");
  // Always of the same range, so that asking for another one does not change it.
  RangeResult usual = slope_in(scene, out, AnalysisOptions().ranges.front());
  const RangeResult* lowest = usual.sensitivity ? &usual : nullptr;
  for (const RangeResult& r : out.ranges) {
    if (usual.sensitivity || !r.sensitivity) continue;
    if (lowest == nullptr || r.range.from_kPa < lowest->range.from_kPa) lowest = &r;
  }
  if (lowest == nullptr || !out.noise || lowest->sensitivity.value() == 0 ||
      !(out.noise.value() > 0)) {
    out.limit_of_detection.reason = "it takes a noise and a sensitivity that are not 0";
    return;
  }
  const double slope = lowest->sensitivity.value();
  const double value = 3 * out.noise.value() / std::abs(slope);
  Estimate e;
  e.value = value;
  if (const auto se = lowest->sensitivity.estimate->standard_error) {
    const Estimate &noise = *out.noise.estimate, &of_slope = *lowest->sensitivity.estimate;
    const auto scaled = [&](double relative, const Estimate& of) {
      return SlopePart{value * std::abs(relative), of.degrees_of_freedom.value_or(1)};
    };
    e = estimate_of_parts(
        value, {scaled(*noise.standard_error / noise.value, noise), scaled(*se / slope, of_slope)},
        scene.options.confidence);
  }
  out.limit_of_detection.estimate = e;
  out.limit_of_detection.rows = lowest->sensitivity.rows + out.noise.rows;
  out.limit_of_detection.reason = fmt::format("with the slope of {}", range_text(lowest->range));
}

Result<RunAnalysis> analyse(const RunData& data, const AnalysisOptions& options) {
  if (auto ok = check(options); !ok) return fail(ok.error());
  RunAnalysis out;
  out.run = data.run;
  out.protocol = data.row.protocol_name;
  out.specimen = data.row.specimen_name;
  out.function = data.function;
  out.simulated = data.row.simulated;
  out.exit_status = data.listing.exit_status;
  out.options = options;
  add_notes(data, out);
  Scene scene = look_at(data, options, out);
  find_cycles(scene, out);
  find_drift(scene, out);
  calc_levels(scene, out);
  calc_holds(scene, out);
  calc_baseline(scene, out);
  calc_curve(scene, out);
  calc_cycles(scene, out);
  calc_sensitivity(scene, out);
  calc_hysteresis(scene, out);
  calc_limit_of_detection(scene, out);
  calc_uncertainties(scene, out);
  add_level_notes(data, out);
  return out;
}

Result<RunAnalysis> analyse(const Database& db, std::int64_t run, const AnalysisOptions& options) {
  if (auto ok = check(options); !ok) return fail(ok.error());
  auto data = load_run_data(db, run);
  if (!data) return fail(data.error());
  return analyse(*data, options);
}

std::vector<const Metric*> RunAnalysis::metrics() const {
  std::vector<const Metric*> list{&c0, &noise, &drift};
  for (const RangeResult& r : ranges) list.push_back(&r.sensitivity);
  for (const Metric* m :
       {&linearity, &linearity_terminal, &repeatability_range, &repeatability_2sigma,
        &dynamic_range, &dynamic_range_drift, &force_sensitivity, &hysteresis.largest_gap,
        &hysteresis.area, &mullins, &creep, &settling, &limit_of_detection}) {
    list.push_back(m);
  }
  return list;
}

}  // namespace lcrig
