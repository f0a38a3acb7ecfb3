// SPDX-License-Identifier: Apache-2.0
// Slope of C against force at the peak. It converts an error of the force into an error of the
// peak. The mean slope of a bent curve would be different.
#include <cmath>
#include <set>

#include "analysis/least_squares.hpp"
#include "analysis/metrics.hpp"
#include "analysis/peak_curve.hpp"

namespace lcrig {

namespace {

constexpr double kApart = 0.08;  // of the peak force: closer forces count as one

// Readings on the way up, in the upper half of the force.
struct UpperHalf {
  std::vector<double> part, delta_fF;  // force over peak, less 1; C above the cycle's rest
  std::size_t forces = 0;  // number of different forces
};

UpperHalf upper_half(const Scene& scene, const std::vector<CycleResult>& cycles) {
  UpperHalf out;
  std::set<int> forces;
  for (const CycleResult& c : cycles) {
    const double rest_fF = c.rest_pF * 1e3 - scene.drift.at(c.rest_s);
    for (std::size_t i = c.first; i < c.last; ++i) {
      const RunReading& r = scene.data.readings[i];
      if (r.t_s > c.peak_s || !r.has_force() || !scene.uses(r)) continue;
      const double part = scene.above_rest_N(r) / c.peak_force_N - 1;
      if (part < PeakCurve::kUpper - 1) continue;
      out.part.push_back(part);
      out.delta_fF.push_back(scene.fF(r) - rest_fF);
      forces.insert(static_cast<int>(std::lround(part / kApart)));
    }
  }
  out.forces = forces.size();
  return out;
}

std::optional<LeastSquares::Solution> fit(const UpperHalf& readings, std::size_t columns) {
  LeastSquares out(columns);
  for (std::size_t i = 0; i < readings.part.size(); ++i) {
    const double d = readings.part[i];
    const double row[] = {1, d, d * d, d * d * d};
    out.add(row, readings.delta_fF[i]);
  }
  return out.solve();
}

// True if the coefficient of the highest power is more than twice its standard error.
bool stands_out(const LeastSquares::Solution& s) {
  if (s.freedom < 1) return false;
  const double variance = s.residual_ss / s.freedom * s.unit_covariance.back();
  return s.value.back() * s.value.back() > 4 * variance;
}

}  // namespace

// A bend that does not exceed its scatter is left out. If there are not two different forces, only
// the slope from the rest to the peak is known.
double slope_at_peak_fF_per_N(const Scene& scene, const std::vector<CycleResult>& cycles) {
  double peak_N = 0, delta_fF = 0;
  for (const CycleResult& c : cycles) peak_N += c.peak_force_N, delta_fF += c.delta_C_fF;
  const UpperHalf readings = upper_half(scene, cycles);
  peak_N /= static_cast<double>(cycles.size());
  delta_fF /= static_cast<double>(cycles.size());
  for (const std::size_t columns : {4U, 3U}) {
    if (readings.forces <= columns) continue;
    const auto bent = fit(readings, columns);
    if (bent && stands_out(*bent)) return bent->value[1] / peak_N;
  }
  if (readings.forces >= 2) {
    if (const auto straight = fit(readings, 2)) return straight->value[1] / peak_N;
  }
  return delta_fF / peak_N;
}

}  // namespace lcrig
