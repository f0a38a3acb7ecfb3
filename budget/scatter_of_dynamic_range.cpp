// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "analysis/least_squares.hpp"
#include "analysis/peak_curve.hpp"
#include "base/online.hpp"
#include "budget/loading_path.hpp"
#include "budget/scatter.hpp"

namespace lcrig {

namespace {

// Share of the readings near the peak that must belong to a hold for the force to count as steady.
constexpr double kHeld = 0.75;

// Pressures of the readings that the fit takes, relative to the peak, less 1.
std::vector<double> upper_half(const std::vector<double>& kPa, double peak_kPa) {
  std::vector<double> out;
  for (const double p : kPa) {
    if (p >= PeakCurve::kUpper * peak_kPa) out.push_back(p / peak_kPa - 1);
  }
  return out;
}

// `nearest_s`: time from the last reading to the peak.
std::vector<double> rising_kPa(const PlannedRun& run, const PlannedCycle& cycle, double nearest_s) {
  if (cycle.loading_s > 0) {
    return LoadingPath(run, cycle.peak_kPa, cycle.loading_s).kPa(nearest_s);
  }
  std::vector<double> out;
  for (const PlannedStretch& s : cycle.rising) {
    const double n = std::round(s.readings);
    for (double i = 0.5; i < n; ++i) out.push_back(s.from_kPa + i / n * (s.to_kPa - s.from_kPa));
  }
  return out;
}

// Variance of C at the peak from the fit to the upper half of the force, if a reading has variance
// 1. The readings continue through the turn: the nearer the last one before it, the farther the
// first one after it.
double unit_variance_of_fit(const PlannedRun& run, const PlannedCycle& cycle) {
  const LoadingPath falling(run, cycle.peak_kPa, cycle.falling_s);
  double mean = 0;
  for (const double phase : kPhases) {
    const auto up = upper_half(rising_kPa(run, cycle, phase * run.interval_s), cycle.peak_kPa);
    const auto down = upper_half(falling.kPa((1 - phase) * run.interval_s), cycle.peak_kPa);
    const PeakCurve curve(std::ssize(up), std::ssize(down));
    LeastSquares fit(curve.columns());
    for (const double d : up) fit.add(curve.row(d, true).data(), 0);
    for (const double d : down) fit.add(curve.row(d, false).data(), 0);
    const auto solution = fit.solve();
    mean += (solution && solution->freedom >= 1 ? solution->unit_covariance[0] : 1.0) /
            std::size(kPhases);
  }
  return mean;
}

// The share of a stretch that already lies at the peak.
double share_of_plateau(const PlannedStretch& s, double peak_kPa) {
  const double from = kPlateau * peak_kPa;
  if (s.from_kPa >= from) return 1;
  return s.to_kPa > from ? (s.to_kPa - from) / (s.to_kPa - s.from_kPa) : 0;
}

struct PeakScatter {
  double unit_variance = 0;  // of C at the peak, if a reading has variance 1
  double force_kPa = 0;  // standard deviation of the force that counts as the peak
  double turn_fF = 0;  // error from windows that reach over the turn
};

// As in the analysis: a twelfth of rate times window.
double turn_fF(const PlannedRun& run, const PlannedCycle& cycle) {
  const double window = window_s(run);
  double rate_kPa_s = 0;
  for (const double seconds : {cycle.loading_s, cycle.falling_s}) {
    if (seconds <= window) continue;
    const LoadingPath path(run, cycle.peak_kPa, seconds);
    rate_kPa_s = std::max(rate_kPa_s, path.rate_kPa_s(window / 2));
  }
  const double slope = even_slope(run, {0, cycle.peak_kPa}, cycle.peak_kPa);
  return std::abs(slope) * rate_kPa_s * std::hypot(window, run.sample_s) / 12;
}

// The force of the highest sample counts, which is up to half an interval away from the turn.
double scatter_of_turn_kPa(const PlannedRun& run, const PlannedCycle& cycle) {
  if (cycle.loading_s <= 0 || run.sample_s <= 0) return 0;
  const LoadingPath loading(run, cycle.peak_kPa, cycle.loading_s);
  return loading.short_of_peak_kPa(run.sample_s / 2) / std::sqrt(12);
}

// Scatter of the mean of a plateau, or without a plateau that of the fit. nullopt: there is no
// reading under load.
std::optional<PeakScatter> scatter_of_peak(const PlannedRun& run, const PlannedCycle& cycle) {
  double readings = 0, seconds = 0, held = 0, all = 0, of_level = 0;
  for (const PlannedStretch& s : cycle.rising) {
    const double share = share_of_plateau(s, cycle.peak_kPa);
    readings += share * s.readings;
    seconds += share * s.seconds;
    if (s.from_kPa == s.to_kPa) held += share * s.readings;
    if (s.is_level) of_level += share * s.readings;
    all += s.readings;
  }
  if (of_level >= static_cast<double>(kPlateauReadings)) return PeakScatter{1 / of_level, 0, 0};
  const bool steady = seconds >= kPlateauTime_s || held >= kHeld * readings;
  if (readings >= static_cast<double>(kPlateauReadings) && steady) {
    return PeakScatter{1 / readings, 0, 0};
  }
  if (cycle.loading_s <= 0 && all < 1) return std::nullopt;
  return PeakScatter{unit_variance_of_fit(run, cycle), scatter_of_turn_kPa(run, cycle),
                     turn_fF(run, cycle)};
}

// Weight of each rest in the mean of (peak - rest) over the cycles: as the rest before a cycle, and
// through the line of drift, which is subtracted from rest to peak.
std::vector<double> influence_of_rests(const PlannedRun& run) {
  const auto cycles = static_cast<double>(run.cycles.size());
  double carried_s = 0;
  RunningLine line;
  for (std::size_t k = 0; k < run.rests.size(); ++k) {
    const PlannedRest& r = run.rests[k];
    if (r.readings >= static_cast<double>(kLeastOfRest)) line.add(r.t_s, 0, r.readings);
    if (k < run.cycles.size()) carried_s += (run.cycles[k].peak_s - r.t_s) / cycles;
  }
  std::vector<double> out;
  for (std::size_t k = 0; k < run.rests.size(); ++k) {
    const PlannedRest& r = run.rests[k];
    out.push_back(k < run.cycles.size() ? -1 / cycles : 0);
    if (r.readings < static_cast<double>(kLeastOfRest) || !(line.sxx() > 0)) continue;
    out.back() -= r.readings * (r.t_s - line.x_mean()) / line.sxx() * carried_s;
  }
  return out;
}

}  // namespace

// Predicts the mean over the cycles of (peak - rest)/C0, percent.
std::optional<Scatter> scatter_of_dynamic_range(const PlannedRun& run) {
  const auto n = static_cast<double>(run.cycles.size());
  // Variances of the mean over the cycles: `meter` for a noise of 1, the others in fF2.
  double meter = 0, force = 0, turns = 0;
  double delta_fF = 0, systematic_fF = 0;
  std::optional<PeakScatter> peak;
  for (std::size_t k = 0; k < run.cycles.size(); ++k) {
    const PlannedCycle& c = run.cycles[k];
    if (k >= run.rests.size() || run.rests[k].readings < 0.5) return std::nullopt;
    if (k == 0 || !same_loading(run.cycles[k - 1], c)) peak = scatter_of_peak(run, c);
    if (!peak) return std::nullopt;
    meter += peak->unit_variance / n / n;
    const double h = 0.01 * c.peak_kPa;
    const double slope =
        (run.delta_C_fF(c.peak_kPa + h) - run.delta_C_fF(c.peak_kPa - h)) / (2 * h);
    const double scatter = slope * force_noise_kPa(run);
    force += scatter * scatter * peak->unit_variance / n / n;
    systematic_fF += peak->turn_fF / n;
    turns += slope * slope * peak->force_kPa * peak->force_kPa / n / n;
    delta_fF += run.delta_C_fF(c.peak_kPa) / n;
  }
  const double c0_fF = run.c0_F * 1e15;
  auto influence = influence_of_rests(run);
  influence[0] -= delta_fF / c0_fF;  // C0 comes from the same readings
  for (std::size_t k = 0; k < influence.size(); ++k) {
    if (influence[k] != 0) meter += influence[k] * influence[k] / run.rests[k].readings;
  }
  Scatter out;
  out.value = delta_fF / c0_fF * 100;
  out.force = std::sqrt(force) / c0_fF * 100;
  out.instants = std::sqrt(turns) / c0_fF * 100;
  out.turn = systematic_fF / c0_fF * 100;
  out.meter = std::sqrt(meter) * run.reading_noise_F * 1e15 / c0_fF * 100;
  return out;
}

}  // namespace lcrig
