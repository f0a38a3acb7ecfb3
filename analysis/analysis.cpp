// SPDX-License-Identifier: Apache-2.0
#include "analysis/analysis.hpp"

#include <algorithm>
#include <cmath>

#include "analysis/metrics.hpp"

namespace lcrig {

namespace {

PressureArea pressure_of(const RunData& data, const AnalysisOptions& options) {
  PressureArea out = data.pressure;
  out.probe_limit_m = options.rig.diameter_limit_mm() * 1e-3;
  return out;
}

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

// The first look at the readings: which are under load, which are at rest, and the levels.
struct Stretches {
  Stretches(const RunData& data, const AnalysisOptions& options)
      : view(look_at(data, options)),
        rests(find_rests(view, find_loadings(view))),
        measured(measure_levels(view, rests)) {}
  RunView view;
  Rests rests;
  MeasuredLevels measured;
};

RunAnalysis analyse_stretches(const Stretches& in) {
  const RunData& data = in.view.data;
  const AnalysisOptions& options = in.view.options;
  const MeasuredLevels& measured = in.measured;
  const Scene scene(in.view, in.rests, measured);
  const auto holds = calc_holds(scene);
  const auto baseline = calc_baseline(scene, measured);
  const auto levels = calc_levels(scene, measured, baseline.c0);
  const auto curve = calc_curve(levels, baseline.c0, options.confidence);
  const auto highest = calc_highest_level(scene, levels, curve, baseline.c0);
  const auto cycles = calc_cycles(scene, holds, baseline.c0);
  const auto hysteresis = calc_hysteresis(scene, cycles, holds);
  const SlopeBasis basis{scene, holds, baseline, levels, curve, highest, cycles, hysteresis};
  const auto sensitivity = calc_sensitivity(basis);
  const auto c0_pF = baseline.c0 ? std::optional(baseline.c0.value()) : std::nullopt;
  const RunFacts facts{data.run,
                       data.row.protocol_name,
                       data.row.specimen_name,
                       data.function,
                       data.row.simulated,
                       data.listing.exit_status,
                       data.proof_known,
                       data.unproven_readings,
                       options,
                       pressure_of(data, options),
                       conditions_of(in.view, c0_pF)};
  RunAnalysis out{facts,
                  measured.outliers,
                  baseline,
                  levels,
                  curve,
                  highest,
                  cycles,
                  holds,
                  sensitivity,
                  hysteresis,
                  calc_uncertainties(basis, sensitivity),
                  calc_notes(scene, measured, holds),
                  {},
                  measured.drift_in_levels};
  add_remarks(scene, out);
  return out;
}

}  // namespace

Result<RunAnalysis> analyse(const RunData& data, const AnalysisOptions& options) {
  if (auto ok = check(options); !ok) return fail(ok.error());
  const Stretches stretches(data, options);
  const auto hum = find_hum(stretches.view, stretches.rests, stretches.measured);
  if (!hum) return analyse_stretches(stretches);
  const RunData steady = without(*hum, data);
  RunAnalysis out = analyse_stretches(Stretches(steady, options));
  out.hum = hum;
  out.notes.push_back(note_on(*hum));
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
       {&linearity, &linearity_terminal, &repeatability_range, &repeatability_2sigma, &delta_C,
        &dynamic_range, &dynamic_range_drift, &force_sensitivity, &hysteresis.largest_gap,
        &hysteresis.area, &mullins, &creep, &settling, &limit_of_detection}) {
    list.push_back(m);
  }
  return list;
}

const Uncertainty* RunAnalysis::uncertainty_of(const Metric& metric) const {
  if (const RangeResult* r = range_of(metric)) {
    return r->uncertainty.parts.empty() ? nullptr : &r->uncertainty;
  }
  const std::pair<const Metric*, UncertainResult> known[] = {
      {&c0, UncertainResult::c0},
      {&delta_C, UncertainResult::delta_C},
      {&dynamic_range, UncertainResult::dynamic_range},
      {&force_sensitivity, UncertainResult::force_sensitivity},
      {&hysteresis.largest_gap, UncertainResult::hysteresis}};
  for (const auto& [of, result] : known) {
    if (of != &metric) continue;
    const auto it = std::ranges::find(uncertainties, result, &Uncertainty::result);
    return it == uncertainties.end() ? nullptr : &*it;
  }
  return nullptr;
}

const RangeResult* RunAnalysis::range_of(const Metric& metric) const {
  for (const RangeResult& r : ranges) {
    if (&r.sensitivity == &metric) return &r;
  }
  return nullptr;
}

}  // namespace lcrig
