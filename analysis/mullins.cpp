// SPDX-License-Identifier: Apache-2.0
// By how much the last peak of a run differs from the first: the softening that Mullins described.
#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/line_fit.hpp"
#include "analysis/metrics.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr double kEqual = 0.02;  // share of the largest; peaks within it are comparable

double spread(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high > 0 ? (*high - *low) / *high : std::numeric_limits<double>::infinity();
}

// Standard error of the index from the fits of both peaks. Where it is larger, the scatter of all
// peaks about a straight line over the cycles is used, because cycles may differ by more than their
// readings show.
SlopePart error_of_mullins(const CycleResults& out) {
  const CycleResult &first = out.cycles.front(), &last = out.cycles.back();
  const double ratio = last.delta_C_fF / first.delta_C_fF;
  const double a = first.delta_C_se_fF.value_or(0), b = last.delta_C_se_fF.value_or(0);
  SlopePart error{std::hypot(b, ratio * a), std::numeric_limits<double>::infinity()};
  std::vector<LinePoint> peaks;
  peaks.reserve(out.cycles.size());
  for (const CycleResult& c : out.cycles) {
    peaks.push_back({static_cast<double>(c.number), c.delta_C_fF});
  }
  const auto line = fit_line(peaks);
  if (line && line->points >= 3) {
    const double freedom = line->points - 2;
    const double scatter = std::sqrt(line->residual_ss / freedom) * std::hypot(1, ratio);
    if (scatter > error.se) error = {scatter, freedom};
  }
  error.se *= 100 / std::abs(first.delta_C_fF);
  return error;
}

// A turn overshoots by varying amounts, so the last peak is corrected to the force of the first.
void set_mullins_to_equal_force(const Scene& scene, CycleResults& out) {
  const CycleResult &first = out.cycles.front(), &last = out.cycles.back();
  const double more_fF =
      slope_at_peak_fF_per_N(scene, out.cycles) * (last.peak_force_N - first.peak_force_N);
  const double percent = more_fF / first.delta_C_fF * 100;
  out.mullins.estimate->value += percent;
  if (!out.mullins.estimate->interval) return;
  for (double& end : *out.mullins.estimate->interval) end += percent;
}

}  // namespace

void calc_mullins(const Scene& scene, CycleResults& out) {
  const auto contact = contact_mm(scene);
  std::vector<double> forces, travels;  // since contact, because the machine's zero is arbitrary
  for (const CycleResult& c : out.cycles) {
    forces.push_back(c.peak_force_N);
    if (contact && c.peak_travel_mm) travels.push_back(std::abs(*c.peak_travel_mm - *contact));
  }
  const CycleResult &first = out.cycles.front(), &last = out.cycles.back();
  out.mullins.rows = first.loaded_readings + last.loaded_readings;
  if (spread(forces) <= kEqual && first.delta_C_fF != 0) {
    const double percent = (1 - last.delta_C_fF / first.delta_C_fF) * 100;
    const auto [se, freedom] = error_of_mullins(out);
    out.mullins.estimate =
        se > 0 ? estimate(percent, se, freedom, scene.options.confidence) : Estimate(percent);
    set_mullins_to_equal_force(scene, out);
    out.mullins.reason = "of delta C at equal peak force";
    if (out.cycles.size() == 2) {
      add_remark(out.mullins.reason, "two cycles: the interval knows nothing of what else differs");
    }
  } else if (travels.size() == out.cycles.size() && spread(travels) <= kEqual) {
    out.mullins.estimate = Estimate((1 - last.peak_force_N / first.peak_force_N) * 100);
    out.mullins.reason = "of the peak force at equal travel";
  } else {
    out.mullins.reason = "the cycles have neither the same peak force nor the same peak travel";
  }
}

}  // namespace lcrig
