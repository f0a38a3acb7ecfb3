// SPDX-License-Identifier: Apache-2.0
// Loading against unloading, all cycles together.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/least_squares.hpp"
#include "analysis/metrics.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kOrder = 3;  // of the polynomial of a branch
constexpr std::int64_t kLeastOfBranch = 12;  // of a branch, all cycles together
constexpr double kFrom = 0.1, kTo = 0.95;  // of the peak: contact and turning point excluded
constexpr int kGrid = 18;
constexpr const char* kLargestGap =
    "largest difference between unloading and loading at equal force, over the span of C; both "
    "branches as cubics through the readings of all cycles between 10 and 95 % of the peak force, "
    "force taken in the middle of each reading's window; holds left out; cycles whose delta C "
    "differ by "
    "more than a fifth are scaled to the mean one";
constexpr const char* kArea =
    "area between unloading and loading over (span of C times range of force), same branches";

// Polynomials in u = force / peak, scaled to -1..1 over the fitted part; fF above rest.
void fill(double u, std::array<double, kOrder + 1>& row) {
  const double v = (2 * u - kFrom - kTo) / (kTo - kFrom);
  row[0] = 1;
  for (std::size_t i = 1; i <= kOrder; ++i) row[i] = row[i - 1] * v;
}

struct Branches {
  LeastSquares up{kOrder + 1}, down{kOrder + 1};
  double square_rate_error = 0;  // of (rate of force times uncertainty of the instant), N2
  std::int64_t counts = 0;
};

// `late`: the force at the end of the window instead of its middle, from the rate of force.
void add_reading(const Scene& scene, const CycleResult& c, std::size_t i, double scale, bool late,
                 Branches& out) {
  const RunReading& r = scene.data.readings[i];
  if (spans_turn(c, r)) return;
  const double delay = late ? r.half_window_s() : 0;
  const double u = (scene.above_rest_N(r) + r.force_rate_N_s * delay) / c.peak_force_N;
  if (u < kFrom || u > kTo) return;
  const bool up = r.t_s <= c.peak_s;
  std::array<double, kOrder + 1> row{};
  fill(u, row);
  (up ? out.up : out.down).add(row.data(), scale * (r.capacitance_F * 1e12 - c.rest_pF) * 1e3);
  const double error = r.alignment_N();
  out.square_rate_error += error * error;
  ++out.counts;
}

// Cycles of different height (presses at different places) are brought to the mean one.
constexpr double kAlike = 0.2;

double mean_height_fF(const RunAnalysis& out) {
  double sum = 0;
  for (const CycleResult& c : out.cycles) sum += std::abs(c.delta_C_fF);
  return sum / static_cast<double>(out.cycles.size());
}

std::vector<double> scales(const RunAnalysis& out) {
  const double span = mean_height_fF(out);
  std::vector<double> scale;
  bool alike = true;
  for (const CycleResult& c : out.cycles) {
    alike = alike && std::abs(c.delta_C_fF - out.cycles.front().delta_C_fF) <= kAlike * span;
    scale.push_back(c.delta_C_fF != 0 ? span / c.delta_C_fF : 0);
  }
  if (alike) scale.assign(out.cycles.size(), 1);
  return scale;
}

Branches collect(const Scene& scene, const RunAnalysis& out, bool late) {
  Branches b;
  Moving moving(scene, out);
  const auto scale = scales(out);
  for (std::size_t k = 0; k < out.cycles.size(); ++k) {
    const CycleResult& c = out.cycles[k];
    for (std::size_t i = c.first; i < c.last; ++i) {
      if (moving(i)) add_reading(scene, c, i, scale[k], late, b);
    }
  }
  return b;
}

double value_at(const std::vector<double>& coefficients,
                const std::array<double, kOrder + 1>& row) {
  double sum = 0;
  for (std::size_t i = 0; i <= kOrder; ++i) sum += coefficients[i] * row[i];
  return sum;
}

struct Loop {
  LeastSquares::Solution up, down;
  double variance = 0;
  std::vector<LoopPoint> points;
  std::size_t largest = 0;
  double area = 0, area_variance = 0;  // mean gap over the range, fF
};

std::optional<Loop> make_loop(const Branches& b, double peak_N) {
  auto up = b.up.solve(), down = b.down.solve();
  if (!up || !down || b.up.rows() < kLeastOfBranch || b.down.rows() < kLeastOfBranch) {
    return std::nullopt;
  }
  Loop loop;
  loop.variance = (up->residual_ss + down->residual_ss) / (up->freedom + down->freedom);
  std::array<double, kOrder + 1> row{};
  std::vector<double> mean_row(kOrder + 1, 0.0);
  for (int k = 0; k < kGrid; ++k) {
    const double u = kFrom + (kTo - kFrom) * k / (kGrid - 1);
    fill(u, row);
    const std::vector<double> factor(row.begin(), row.end());
    LoopPoint p;
    p.force_N = u * peak_N;
    p.up_fF = value_at(up->value, row);
    p.down_fF = value_at(down->value, row);
    p.gap_se_fF =
        std::sqrt(loop.variance * (up->unit_variance(factor) + down->unit_variance(factor)));
    for (std::size_t i = 0; i <= kOrder; ++i) mean_row[i] += row[i] / kGrid;
    loop.area += (p.down_fF - p.up_fF) / kGrid;
    loop.points.push_back(p);
    const LoopPoint& l = loop.points[loop.largest];
    if (std::abs(p.down_fF - p.up_fF) > std::abs(l.down_fF - l.up_fF)) {
      loop.largest = static_cast<std::size_t>(k);
    }
  }
  loop.area_variance =
      loop.variance * (up->unit_variance(mean_row) + down->unit_variance(mean_row));
  loop.up = std::move(*up);
  loop.down = std::move(*down);
  return loop;
}

double gap_fF(const LoopPoint& p) {
  return p.down_fF - p.up_fF;
}

double mean_peak_N(const RunAnalysis& out) {
  double sum = 0;
  for (const CycleResult& c : out.cycles) sum += c.peak_force_N;
  return sum / static_cast<double>(out.cycles.size());
}

// A common error of the instant shifts loading and unloading apart: 2 (dC/dF) (dF/dt) u.
double alignment_fF(const Branches& b, const Loop& loop, double peak_N) {
  const LoopPoint &first = loop.points.front(), &last = loop.points.back();
  const double slope = (last.up_fF - first.up_fF) / ((kTo - kFrom) * peak_N);
  const double force = std::sqrt(b.square_rate_error / static_cast<double>(b.counts));
  return 2 * std::abs(slope) * force;
}

void fill_result(const Scene& scene, const RunAnalysis& out, const Branches& b, const Loop& loop,
                 Hysteresis& h) {
  const double span = mean_height_fF(out), peak = mean_peak_N(out);
  const LoopPoint& at = loop.points[loop.largest];
  const double freedom = loop.up.freedom + loop.down.freedom;
  const double confidence = scene.options.confidence;
  h.largest_gap.estimate =
      estimate(std::abs(gap_fF(at)) / span * 100, at.gap_se_fF / span * 100, freedom, confidence);
  h.area.estimate = estimate(loop.area / span * 100, std::sqrt(loop.area_variance) / span * 100,
                             freedom, confidence);
  h.largest_gap.rows = h.area.rows = b.counts;
  h.alignment_percent = alignment_fF(b, loop, peak) / span * 100;
  // The largest of many points of a fit stands out by chance more often than one.
  const double noise = coverage_factor(0.99, freedom) * *h.largest_gap.estimate->standard_error;
  const double limit = std::hypot(noise, 2 * *h.alignment_percent);
  h.resolved = h.largest_gap.value() > limit;
  if (!h.resolved) {
    h.largest_gap.reason = fmt::format(
        "not resolved: noise and the instant of the readings alone can make {:.2g} %", limit);
  }
  h.loop = loop.points;
}

}  // namespace

void calc_hysteresis(const Scene& scene, RunAnalysis& out) {
  Hysteresis& h = out.hysteresis;
  h.largest_gap = metric("hysteresis_percent", kLargestGap);
  h.area = metric("hysteresis_area_percent", kArea);
  if (out.cycles.empty()) {
    h.largest_gap.reason = h.area.reason = "no loading was found";
    return;
  }
  const double span = mean_height_fF(out);
  const Branches b = collect(scene, out, false);
  const auto loop = make_loop(b, mean_peak_N(out));
  if (!loop || span <= 0) {
    h.largest_gap.reason = h.area.reason =
        fmt::format("too few readings while the force grew or fell: {} and {}, it takes {} each",
                    b.up.rows(), b.down.rows(), kLeastOfBranch);
    return;
  }
  fill_result(scene, out, b, *loop, h);
  if (const auto late = make_loop(collect(scene, out, true), mean_peak_N(out))) {
    h.uncorrected_percent = std::abs(gap_fF(late->points[late->largest])) / span * 100;
  }
}

}  // namespace lcrig
