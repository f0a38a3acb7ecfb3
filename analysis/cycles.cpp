// SPDX-License-Identifier: Apache-2.0
// Excursions of the force: where they are, and the capacitance at rest and at the peak of each.
#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/even_slope.hpp"
#include "analysis/least_squares.hpp"
#include "analysis/metrics.hpp"
#include "analysis/peak_curve.hpp"
#include "analysis/recovery.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr double kCounts = 0.2;  // of the largest force: a larger excursion is a cycle
// Standard deviation of the force on a plateau, as a share of the peak. A mere turn has 0.6 %.
constexpr double kSteadyPlateau = 0.001, kShakyPlateau = 0.004;
constexpr double kExact = std::numeric_limits<double>::infinity();  // degrees of freedom

void close_loading(const RunView& view, Loading& c, double highest, std::vector<Loading>& out) {
  if (highest < kCounts * view.peak_N) return;
  c.number = static_cast<std::int32_t>(out.size()) + 1;
  c.begin_s = view.data.readings[c.first].t_s;
  c.end_s = view.data.readings[c.last - 1].t_s;
  c.loaded_readings = static_cast<std::int64_t>(c.last - c.first);
  out.push_back(c);
}

std::vector<Loading> find_excursions(const RunView& view) {
  std::vector<Loading> out;
  const auto& readings = view.data.readings;
  const double edge = std::max(kCycleEdge * view.peak_N, 5 * view.force_noise_N);
  bool loaded = false;
  double highest = 0;
  Loading c;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (!readings[i].has_force() || !view.uses(readings[i])) continue;
    const double force = view.above_rest_N(readings[i]);
    if (force > edge && !loaded) {
      c = Loading();
      c.first = i;
      highest = 0;
    }
    if (force <= edge && loaded) close_loading(view, c, highest, out);
    loaded = force > edge;
    if (!loaded) continue;
    c.last = i + 1;
    if (force <= highest) continue;
    highest = force;
    c.peak_s = readings[i].t_s;
    c.peak_force_N = force;
    if (readings[i].has_travel()) c.peak_travel_mm = readings[i].travel_m * 1e3;
  }
  if (loaded) close_loading(view, c, highest, out);
  return out;
}

// Refines the peaks from the frame's samples. The frame samples more often than the meter, so the
// largest force may lie between two readings.
void sharpen_peaks(const RunView& view, std::vector<Loading>& loadings) {
  const auto& frame = view.data.frame;
  for (Loading& c : loadings) {
    const auto before = [](const FramePoint& p, double t) { return p.t_s < t; };
    auto it = std::lower_bound(frame.begin(), frame.end(), c.begin_s, before);
    for (; it != frame.end() && it->t_s <= c.end_s; ++it) {
      const double force = it->force_N - view.rest_N;
      if (!(force > c.peak_force_N)) continue;
      c.peak_force_N = force;
      c.peak_s = it->t_s;
      if (!std::isnan(it->travel_m)) c.peak_travel_mm = it->travel_m * 1e3;
    }
  }
}

// Facts about one peak, from before the scatter of all peaks is pooled.
struct Peak {
  double residual_ss = 0, freedom = 0;  // F2
  double unit_variance = 0;  // 0: the standard error is already known
};

bool on_plateau(const RunView& view, const Loading& c, const RunReading& r) {
  return r.has_force() && view.uses(r) && view.above_rest_N(r) >= kPlateau * c.peak_force_N;
}

// True if the force stays near the peak for two seconds, or if it is as steady as the cell can
// tell. At a turn it is near the peak only for a moment, with values all over the band that counts
// as near.
bool is_held(const RunView& view, double seconds, const std::vector<double>& forces_N,
             double peak_N) {
  const double steady_N =
      std::clamp(2 * view.force_noise_N, kSteadyPlateau * peak_N, kShakyPlateau * peak_N);
  return seconds >= kPlateauTime_s || robust_sigma(forces_N) <= steady_N;
}

// True if a level at the peak has enough readings by itself. The readings of the ramp to it are
// then left out, because their force is smaller.
bool level_is_plateau(const RunView& view, const Loading& c) {
  const auto of_level =
      std::count_if(view.data.readings.begin() + static_cast<std::ptrdiff_t>(c.first),
                    view.data.readings.begin() + static_cast<std::ptrdiff_t>(c.last),
                    [&](const RunReading& r) { return r.index > 0 && on_plateau(view, c, r); });
  return of_level >= kPlateauReadings;
}

bool peak_of_plateau(const RunView& view, Loading& c) {
  const bool level_only = level_is_plateau(view, c);
  RunningMean capacitance, force, time;
  std::vector<double> forces_N;
  for (std::size_t i = c.first; i < c.last; ++i) {
    const RunReading& r = view.data.readings[i];
    if (!on_plateau(view, c, r) || (level_only && r.index <= 0)) continue;
    if (capacitance.count == 0) c.plateau_first = i;
    c.plateau_last = i;
    capacitance.add(r.capacitance_F * 1e12);
    force.add(view.above_rest_N(r));
    forces_N.push_back(view.above_rest_N(r));
    time.add(r.t_s);
  }
  if (capacitance.count < kPlateauReadings) return false;
  const auto& readings = view.data.readings;
  const double seconds = readings[c.plateau_last].t_s - readings[c.plateau_first].t_s;
  if (!is_held(view, seconds, forces_N, c.peak_force_N)) return false;
  c.peak_pF = capacitance.mean;
  c.peak_se_fF = capacitance.mean_se() * 1e3;
  c.peak_freedom = static_cast<double>(capacitance.count - 1);
  c.peak_force_N = force.mean;
  c.peak_s = time.mean;
  c.peak_method = PeakMethod::plateau;
  return true;
}

// Fits C against force over the upper half of the force, and takes the value of the fit at the
// peak. The largest reading would be too large by the noise. Each branch has its own slope, and
// both share a bend. With many readings each branch has its own bend, and both share a third order.
//   A window that reaches over the turn takes part, because without it the scatter doubles. Its
// error is one of the parts of the uncertainty.
Peak peak_of_fit(const RunView& view, Loading& c) {
  std::int64_t up = 0, down = 0;
  const auto in_fit = [&](const RunReading& r) {
    return r.has_force() && view.uses(r) &&
           view.above_rest_N(r) >= PeakCurve::kUpper * c.peak_force_N;
  };
  for (std::size_t i = c.first; i < c.last; ++i) {
    const RunReading& r = view.data.readings[i];
    if (in_fit(r)) ++(r.t_s <= c.peak_s ? up : down);
  }
  const PeakCurve curve(up, down);
  LeastSquares fit(curve.columns());
  double nearest = 0, distance = -1;
  for (std::size_t i = c.first; i < c.last; ++i) {
    const RunReading& r = view.data.readings[i];
    if (!r.has_force() || !view.uses(r)) continue;
    const double d = view.above_rest_N(r) / c.peak_force_N - 1;
    if (distance < 0 || std::abs(d) < distance) distance = std::abs(d), nearest = r.capacitance_F;
    if (in_fit(r)) fit.add(curve.row(d, r.t_s <= c.peak_s).data(), r.capacitance_F);
  }
  const auto solution = fit.solve();
  if (!solution || solution->freedom < 1) {
    c.peak_pF = nearest * 1e12;
    c.peak_method = PeakMethod::nearest;
    return {};
  }
  c.peak_pF = solution->value[0] * 1e12;
  return {solution->residual_ss, solution->freedom, solution->unit_covariance[0]};
}

void set_peaks(const RunView& view, std::vector<Loading>& loadings) {
  std::vector<Peak> peaks;
  double ss = 0, freedom = 0;
  for (Loading& c : loadings) {
    peaks.push_back(peak_of_plateau(view, c) ? Peak() : peak_of_fit(view, c));
    ss += peaks.back().residual_ss;
    freedom += peaks.back().freedom;
    c.peak_kPa = view.kPa(c.peak_force_N);
  }
  for (std::size_t k = 0; k < peaks.size(); ++k) {
    if (peaks[k].unit_variance <= 0 || freedom < 1) continue;
    loadings[k].peak_se_fF = std::sqrt(ss / freedom * peaks[k].unit_variance) * 1e15;
    loadings[k].peak_freedom = freedom;
  }
}

// Slope of C against force on the loading branch.
void set_branch_slopes(const Scene& scene, const HoldResults& holds,
                       std::vector<CycleResult>& cycles) {
  double peak_N = 0;
  for (const CycleResult& c : cycles) peak_N += c.peak_force_N / static_cast<double>(cycles.size());
  EvenSlopes slopes(kCycleEdge * peak_N, peak_N);
  std::vector<CycleResult*> known;
  Moving moving(scene, holds);
  for (CycleResult& c : cycles) {
    std::vector<LinePoint> points;
    for (std::size_t i = c.first; i < c.last; ++i) {
      const RunReading& r = scene.data.readings[i];
      if (!moving(i) || r.t_s > c.peak_s || spans_turn(c, r)) continue;
      points.push_back({scene.above_rest_N(r), scene.fF(r), 1});
    }
    if (points.size() >= 3 && slopes.add(points)) known.push_back(&c);
  }
  const auto lines = slopes.lines();
  for (std::size_t k = 0; k < known.size(); ++k) {
    known[k]->slope_fF_per_N = lines[k].slope;
    known[k]->slope_se_fF_per_N = lines[k].slope_se() * scene.correlation.widening();
    known[k]->slope_freedom = static_cast<double>(lines[k].points - 2);
  }
}

// Mean over cycles. Its error comes from their scatter alone, because nothing else shows how cycles
// differ. With one cycle the error is `single`, which comes from the readings.
Estimate mean_of_cycles(const std::vector<double>& values, const std::optional<SlopePart>& single,
                        double confidence) {
  RunningMean s;
  for (const double v : values) s.add(v);
  if (s.count >= 2) {
    return estimate(s.mean, s.mean_se(), static_cast<double>(s.count - 1), confidence);
  }
  return single ? estimate(s.mean, single->se, single->degrees_of_freedom, confidence)
                : Estimate(s.mean);
}

// Error of the result of one cycle that `scale` independent readings determine.
std::optional<SlopePart> error_of_single(const Scene& scene, std::optional<double> se,
                                         double scale) {
  if (!se) return std::nullopt;
  return SlopePart{*se, std::max(1.0, scene.correlation.freedom_of(scale))};
}

// All cycles share the error of the drift that is subtracted, and what of it is recovery.
void add_common_errors_of_dynamic_range(const Scene& scene, const DriftLeft& left_fF, double c0_pF,
                                        CycleResults& out) {
  const Estimate e = *out.dynamic_range.estimate;
  if (!e.standard_error) return;
  out.parts_of_dynamic_range = {{*e.standard_error, e.degrees_of_freedom.value_or(kExact)}};
  if (!scene.drift.known()) return;
  for (SlopePart part : {left_fF.rate, left_fF.recovery}) {
    part.se *= std::abs(100 / (c0_pF * 1e3));
    out.parts_of_dynamic_range.push_back(part);
  }
  out.dynamic_range.estimate =
      estimate_of_parts(e.value, out.parts_of_dynamic_range, scene.options.confidence);
}

void calc_dynamic_range(const Scene& scene, const DriftLeft& left_fF, double c0_pF,
                        CycleResults& out) {
  const double confidence = scene.options.confidence;
  std::vector<double> percents;
  std::vector<LinePoint> line_points;
  bool rises = false, falls = false;
  for (CycleResult& c : out.cycles) {
    c.dynamic_range_percent = c.delta_C_fF / (c0_pF * 1e3) * 100;
    if (c.delta_C_se_fF) c.dynamic_range_se_percent = *c.delta_C_se_fF / (c0_pF * 1e3) * 100;
    percents.push_back(c.dynamic_range_percent);
    line_points.push_back({static_cast<double>(c.number), c.dynamic_range_percent, 1});
    out.dynamic_range.rows += c.loaded_readings;
    (c.delta_C_fF > 0 ? rises : falls) = true;
  }
  const CycleResult& first = out.cycles.front();
  out.dynamic_range.estimate = mean_of_cycles(
      percents, error_of_single(scene, first.dynamic_range_se_percent, first.peak_freedom),
      confidence);
  add_common_errors_of_dynamic_range(scene, left_fF, c0_pF, out);
  if (out.cycles.size() == 1) out.dynamic_range.reason = kOneCycle;
  if (rises && falls) {
    out.dynamic_range.reason =
        "the capacitance rises in some loadings and falls in others: their mean says little, look "
        "at the cycles";
  }
  const auto line = fit_line(line_points);
  if (!line || line->points < 3) {
    out.dynamic_range_drift.reason = "it takes three cycles";
    return;
  }
  out.dynamic_range_drift.rows = out.dynamic_range.rows;
  out.dynamic_range_drift.estimate =
      estimate(line->slope, line->slope_se(), line->points - 2, confidence);
}

void calc_force_sensitivity(const Scene& scene, CycleResults& out) {
  std::vector<double> slopes;
  std::optional<SlopePart> error;
  for (const CycleResult& c : out.cycles) {
    if (!c.slope_fF_per_N) continue;
    slopes.push_back(*c.slope_fF_per_N);
    error = error_of_single(scene, c.slope_se_fF_per_N, c.slope_freedom);
    out.force_sensitivity.rows += c.loaded_readings;
  }
  if (slopes.empty()) {
    out.force_sensitivity.reason = "fewer than three readings while the load grew";
    return;
  }
  out.force_sensitivity.estimate = mean_of_cycles(slopes, error, scene.options.confidence);
  if (slopes.size() == 1) out.force_sensitivity.reason = kOneCycle;
}

// The subtracted drift and the instants of the readings have the same errors in all loadings, so
// the scatter between loadings does not show them.
void add_common_errors_of_force_sensitivity(const Scene& scene, const HoldResults& holds,
                                            CycleResults& out) {
  if (!out.force_sensitivity || !out.force_sensitivity.estimate->standard_error) return;
  const Estimate& e = *out.force_sensitivity.estimate;
  RunningMean s_per_N, tilt;
  Moving moving(scene, holds);
  for (const CycleResult& c : out.cycles) {
    RunningLine time, rate;
    for (std::size_t i = c.first; i < c.last; ++i) {
      const RunReading& r = scene.data.readings[i];
      if (!moving(i) || r.t_s > c.peak_s || spans_turn(c, r)) continue;
      time.add(scene.above_rest_N(r), r.t_s);
      rate.add(scene.above_rest_N(r), r.force_rate_N_s);
      out.instant_s = std::max(out.instant_s, static_cast<double>(r.alignment_s));
    }
    if (time.count() < 3 || !(time.sxx() > 0)) continue;
    s_per_N.add(time.slope());
    tilt.add(rate.slope());
  }
  out.force_rate_tilt_per_s = tilt.mean;
  const SlopePart scatter{*e.standard_error, e.degrees_of_freedom.value_or(kExact)};
  out.parts_of_force_sensitivity = {scatter};
  const double drift_se = scene.drift.rate_se_fF_s() * std::abs(s_per_N.mean);
  if (!scene.drift.known() || !(drift_se > 0)) return;
  out.parts_of_force_sensitivity.push_back({drift_se, scene.drift.rate_freedom()});
  out.force_sensitivity.estimate =
      estimate_of_parts(e.value, out.parts_of_force_sensitivity, scene.options.confidence);
}

void name_metrics(CycleResults& out) {
  out.dynamic_range =
      metric("dynamic_range", "%",
             "mean over the cycles of (C at the largest force - C at rest before "
             "the cycle) / C0, drift subtracted; standard error from the scatter between "
             "cycles, from the drift, and from what of it may be recovery");
  out.dynamic_range_drift =
      metric("dynamic_range_drift", "% per cycle", "slope of the dynamic range over the cycles");
  out.mullins = metric("mullins_index", "%",
                       "(first peak - last peak) / first peak, of delta C at equal force or of the "
                       "force at equal travel");
  out.force_sensitivity =
      metric("force_sensitivity", "fF/N",
             "mean over the cycles of the least-squares slope of C against force while the load "
             "grows, over forces evenly up to the peak; standard error from the scatter between "
             "cycles and from the drift that is subtracted");
}

CycleResult against_rest(const Scene& scene, const RestedLoading& loading, const Metric& c0) {
  CycleResult c(loading);
  if (c.rest_s == c.begin_s && c0) {  // the cycle has no rest of its own
    c.rest_pF = c0.value();
    if (const auto se = c0.estimate->standard_error) c.rest_se_fF = *se * 1e3;
  }
  const double drifted = scene.drift.at(c.peak_s) - scene.drift.at(c.rest_s);
  c.delta_C_fF = (c.peak_pF - c.rest_pF) * 1e3 - drifted;
  if (c.peak_se_fF) *c.peak_se_fF *= scene.correlation.widening();
  if (c.rest_se_fF && c.peak_se_fF) c.delta_C_se_fF = std::hypot(*c.rest_se_fF, *c.peak_se_fF);
  return c;
}

}  // namespace

std::vector<Loading> find_loadings(const RunView& view) {
  if (view.peak_N <= 0) return {};
  auto loadings = find_excursions(view);
  sharpen_peaks(view, loadings);
  set_peaks(view, loadings);
  return loadings;
}

CycleResults calc_cycles(const Scene& scene, const HoldResults& holds, const Metric& c0) {
  CycleResults out;
  name_metrics(out);
  if (scene.loadings.empty()) {
    const char* why =
        scene.data.has_frame()
            ? "no loading was found: the force stays in its noise, or no reading under load counts"
            : "no force was recorded";
    out.dynamic_range.reason = out.dynamic_range_drift.reason = why;
    out.mullins.reason = out.force_sensitivity.reason = why;
    return out;
  }
  for (const auto& loading : scene.loadings) {
    out.cycles.push_back(against_rest(scene, loading, c0));
  }
  leave_out_other_loadings(scene, out);
  const DriftLeft left_fF = take_out_recovery(scene, holds.creep, out.cycles);
  set_branch_slopes(scene, holds, out.cycles);
  calc_force_sensitivity(scene, out);
  if (c0 && c0.value() != 0) {
    calc_dynamic_range(scene, left_fF, c0.value(), out);
  } else {
    out.dynamic_range.reason = out.dynamic_range_drift.reason = c0 ? "C0 is 0" : "there is no C0";
  }
  if (out.cycles.size() < 2) {
    out.mullins.reason = "it takes two cycles";
  } else {
    calc_mullins(scene, out);
  }
  add_common_errors_of_force_sensitivity(scene, holds, out);
  for (Metric* m :
       {&out.dynamic_range, &out.dynamic_range_drift, &out.mullins, &out.force_sensitivity}) {
    add_remark(m->reason, out.why_left_out);
  }
  name_estimands(scene, out);
  return out;
}

}  // namespace lcrig
