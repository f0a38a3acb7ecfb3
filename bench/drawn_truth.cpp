// SPDX-License-Identifier: Apache-2.0
#include "bench/drawn_truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/line_fit.hpp"
#include "analysis/metrics.hpp"
#include "drivers/lcr6100/sim_values.hpp"

namespace lcrig::worlds {

namespace {

using nlohmann::json;

// The errors that were drawn once for the run.
struct Lasting {
  double meter_gain = 0, meter_offset_F = 0;
  double force_gain = 1;  // shown over true, including the area of the probe
  double creep = 0;
};

Lasting lasting_of(const MeterSetting& meter, const json& drawn) {
  const auto allowed =
      lcr6100::basic_accuracy(meter.aperture == Aperture::fast, meter.frequency_Hz, meter.level_V);
  const auto value = [&](const char* name) { return drawn[name].get<double>(); };
  return {value("meter_gain") * allowed.gain, value("meter_offset") * allowed.offset_F,
          (1 + value("cell_gain")) * (1 + value("probe_area")), value("creep")};
}

double noise_F(const MeterSetting& meter, const PlantConfig& plant) {
  const double once = plant.capacitance_noise_F[static_cast<std::size_t>(meter.aperture)];
  return once * (1000 / meter.frequency_Hz) / meter.level_V / std::sqrt(meter.average);
}

// The force that a specimen remembers, q' = (F - q)/time, at the instants of the readings.
std::vector<double> remembered_N(const RunData& data, double rest_N, double time_s) {
  std::vector<double> out;
  out.reserve(data.readings.size());
  double q = 0, t_s = 0;
  auto sample = data.frame.begin();
  for (const RunReading& r : data.readings) {
    for (; sample != data.frame.end() && sample->t_s <= r.t_s; ++sample) {
      if (std::isnan(sample->force_N)) continue;
      const double keeps = std::exp(-(sample->t_s - t_s) / time_s);
      q = keeps * q + (1 - keeps) * (sample->force_N - rest_N);
      t_s = sample->t_s;
    }
    out.push_back(q);
  }
  return out;
}

// The levels of all repeats at one pressure.
struct TrueLevel {
  double kPa = 0;  // as measured
  Truths delta_fF;
};

// A force scatters when it is shown, not when it acts: each reading of a level gets the mean force.
std::vector<TrueLevel> true_levels(const RunData& data, const RunAnalysis& analysis,
                                   const BenchWorld& world, const Lasting& drawn) {
  const RunView view = look_at(data, analysis.options);
  const auto q = remembered_N(data, view.rest_N, world.plant().config().creep_time_s);
  std::map<LevelKey, RunningMean> force_N;
  std::map<LevelKey, std::pair<RunningMean, RunningMean>> delta_fF;
  for (const int pass : {1, 2}) {
    for (const LevelResult& l : analysis.levels) {
      for (std::size_t i = l.first; i < l.last; ++i) {
        const RunReading& r = data.readings[i];
        if (r.index <= 0 || !r.has_force()) continue;
        RunningMean& force = force_N[key_of(l)];
        if (pass == 1) {
          force.add(view.above_rest_N(r));
          continue;
        }
        const double answered_N = force.mean + drawn.creep * q[i];
        auto& [rig, own] = delta_fF[key_of(l)];
        rig.add((1 + drawn.meter_gain) * 1e15 *
                world.response().delta_capacitance_F(answered_N / drawn.force_gain));
        own.add(1e15 * world.response().delta_capacitance_F(answered_N));
      }
    }
  }
  std::vector<TrueLevel> out;
  for (const auto& [key, delta] : delta_fF) {
    out.push_back({*view.kPa(force_N[key].mean), {delta.first.mean, delta.second.mean}});
  }
  std::ranges::sort(out, {}, &TrueLevel::kPa);
  return out;
}

// The change that is left from the load before, as the mean over the rests before the cycles. A
// result relative to these rests lacks this change.
Truths left_at_rest(const RunData& data, const RunAnalysis& analysis, const BenchWorld& world,
                    const Lasting& drawn) {
  const RunView view = look_at(data, analysis.options);
  const auto q = remembered_N(data, view.rest_N, world.plant().config().creep_time_s);
  const auto n = static_cast<double>(analysis.cycles.size());
  Truths out;
  for (const CycleResult& c : analysis.cycles) {
    const auto at = std::ranges::lower_bound(data.readings, c.rest_s, {}, &RunReading::t_s);
    const double answered_N =
        std::max(0.0, drawn.creep * q[static_cast<std::size_t>(at - data.readings.begin())]);
    out.of_rig += (1 + drawn.meter_gain) * 1e15 / n *
                  world.response().delta_capacitance_F(answered_N / drawn.force_gain);
    out.own += 1e15 / n * world.response().delta_capacitance_F(answered_N);
  }
  return out;
}

std::optional<Truths> slope(const std::vector<TrueLevel>& levels, const PressureRange& range) {
  std::vector<LinePoint> rig, own;
  for (const TrueLevel& l : levels) {
    if (l.kPa < range.from_kPa - 0.5 || l.kPa > range.to_kPa + 0.5) continue;
    rig.push_back({l.kPa, l.delta_fF.of_rig});
    own.push_back({l.kPa, l.delta_fF.own});
  }
  const auto of_rig = fit_line(rig), of_own = fit_line(own);
  if (!of_rig || !of_own) return std::nullopt;
  return Truths{of_rig->slope, of_own->slope};
}

// Twice the pooled standard deviation of a level between repeats, over the span of the curve.
Truths repeatability(const std::vector<TrueLevel>& levels, double readings, double noise_fF) {
  double rig = 0, own = 0;
  for (const TrueLevel& l : levels) {
    const double rest =
        std::pow(BenchErrors::kSeating_F * 1e15, 2) + noise_fF * noise_fF / readings;
    rig += std::pow(BenchErrors::kSlope * l.delta_fF.of_rig, 2) + rest;
    own += std::pow(BenchErrors::kSlope * l.delta_fF.own, 2) + rest;
  }
  const auto n = static_cast<double>(levels.size());
  const Truths &first = levels.front().delta_fF, &last = levels.back().delta_fF;
  return {200 * std::sqrt(rig / n) / (last.of_rig - first.of_rig),
          200 * std::sqrt(own / n) / (last.own - first.own)};
}

double interval_of_baseline_s(const RunData& data) {
  RunningMean interval;
  const double end = data.contact_s.value_or(0);
  for (std::size_t i = 1; i < data.readings.size() && data.readings[i].t_s < end; ++i) {
    interval.add(data.readings[i].t_s - data.readings[i - 1].t_s);
  }
  return interval.mean;
}

}  // namespace

std::map<std::string, Truths> drawn_truths(const RunData& data, const RunAnalysis& analysis,
                                           const BenchWorld& world, const json& json) {
  const MeterSetting meter = data.settings.front().meter;
  const Lasting drawn = lasting_of(meter, json);
  const double drift_fF_h = json["drift_fF_per_h"].get<double>();
  std::map<std::string, Truths> out;
  out["baseline_drift_fF_per_h"] = {drift_fF_h, drift_fF_h};
  // C0 refers to the middle of the baseline.
  const double drifted_pF = drift_fF_h * data.contact_s.value_or(0) / 2 / 3600 * 1e-3;
  const double c0_F = world.response().c0_F();
  const double c0_of_rig_pF = ((1 + drawn.meter_gain) * c0_F + drawn.meter_offset_F) * 1e12;
  out["C0_pF"] = {c0_of_rig_pF + drifted_pF, c0_F * 1e12 + drifted_pF};
  const double white_fF = noise_F(meter, world.plant().config()) * 1e15;
  const double noise_fF = std::hypot(
      white_fF, 1e15 * BenchErrors::noise_between_neighbours_F(interval_of_baseline_s(data)));
  out["noise_fF"] = {noise_fF, noise_fF};
  if (analysis.levels.empty()) return out;
  const auto levels = true_levels(data, analysis, world, drawn);
  for (const RangeResult& r : analysis.ranges) {
    if (const auto truth = slope(levels, r.range)) {
      out[fmt::format("slope {:g}-{:g} kPa", r.range.from_kPa, r.range.to_kPa)] = *truth;
    }
  }
  if (const auto low = slope(levels, AnalysisOptions().ranges.front())) {
    out["limit_of_detection_kPa"] = {3 * noise_fF / low->of_rig, 3 * noise_fF / low->own};
  }
  const Truths top = levels.back().delta_fF;
  out["delta_C_at_top_fF"] = top;
  const Truths left = left_at_rest(data, analysis, world, drawn);
  out["dynamic_range_percent"] = {(top.of_rig - left.of_rig) / (c0_of_rig_pF * 1e3) * 100,
                                  (top.own - left.own) / (c0_F * 1e15) * 100};
  out["repeatability_2sigma_percent"] =
      repeatability(levels, analysis.levels.front().readings, white_fF);
  return out;
}

}  // namespace lcrig::worlds
