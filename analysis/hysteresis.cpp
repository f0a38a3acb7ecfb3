// SPDX-License-Identifier: Apache-2.0
// Compares loading and unloading over all cycles together.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/least_squares.hpp"
#include "analysis/metrics.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kOrder = 3;  // of the polynomial through each branch
constexpr std::int64_t kLeastOfBranch = 12;  // fewest readings of a branch, all cycles together
constexpr double kFrom = 0.1, kTo = 0.95;  // parts of the peak force; contact and turn are excluded
constexpr int kGrid = 18;
constexpr double kInReadings = 3.3;  // standard errors: chance exceeds it once in a thousand
constexpr const char* kLargestGap =
    "largest difference between unloading and loading at equal force, over the span of C; both "
    "branches as cubics through the readings of all cycles between 10 and 95 % of the peak force, "
    "force taken in the middle of each reading's window; holds left out; cycles whose delta C "
    "differ by "
    "more than a fifth are scaled to the mean one";
constexpr const char* kArea =
    "area between unloading and loading over (span of C times range of force), same branches";

using Row = std::array<double, kOrder + 1>;

// Polynomials in u = force / peak. The fitted part of u is scaled to -1..1. C is in fF above rest.
void fill(double u, Row& row) {
  const double v = (2 * u - kFrom - kTo) / (kTo - kFrom);
  row[0] = 1;
  for (std::size_t i = 1; i <= kOrder; ++i) row[i] = row[i - 1] * v;
}

struct Branches {
  LeastSquares up{kOrder + 1}, down{kOrder + 1};
  double square_rate_error = 0;  // (rate of force times uncertainty of the instant)^2, summed, N2
  std::int64_t counts = 0;
};

// One reading of a branch as the fit takes it.
struct Taken {
  std::size_t cycle = 0;
  bool up = false;
  Row row{};
  double fF = 0;  // above C at the cycle's rest, scaled to the mean height of the cycles
};

// `late`: takes the force at the end of the window, by its rate, instead of that in the middle.
std::optional<Taken> taken(const Scene& scene, const CycleResult& c, const RunReading& r,
                           double scale, bool late) {
  if (spans_turn(c, r)) return std::nullopt;
  const double delay = late ? r.half_window_s() : 0;
  const double u = (scene.above_rest_N(r) + r.force_rate_N_s * delay) / c.peak_force_N;
  if (u < kFrom || u > kTo) return std::nullopt;
  Taken out;
  out.up = r.t_s <= c.peak_s;
  fill(u, out.row);
  out.fF = scale * (scene.fF(r) - c.rest_pF * 1e3 + scene.drift.at(c.rest_s));
  return out;
}

// Cycles of different height (such as presses at different places) are scaled to the mean height.
constexpr double kAlike = 0.2;

double mean_height_fF(const std::vector<CycleResult>& cycles) {
  double sum = 0;
  for (const CycleResult& c : cycles) sum += std::abs(c.delta_C_fF);
  return sum / static_cast<double>(cycles.size());
}

std::vector<double> scales(const std::vector<CycleResult>& cycles) {
  const double span = mean_height_fF(cycles);
  std::vector<double> scale;
  bool alike = true;
  for (const CycleResult& c : cycles) {
    alike = alike && std::abs(c.delta_C_fF - cycles.front().delta_C_fF) <= kAlike * span;
    scale.push_back(c.delta_C_fF != 0 ? span / c.delta_C_fF : 0);
  }
  if (alike) scale.assign(cycles.size(), 1);
  return scale;
}

// Input for the fit of the branches.
struct Source {
  const Scene& scene;
  const std::vector<CycleResult>& cycles;
  const HoldResults& holds;
};

template <class Visit>
void each_taken(const Source& from, bool late, Visit visit) {
  const Scene& scene = from.scene;
  Moving moving(scene, from.holds);
  const auto scale = scales(from.cycles);
  for (std::size_t k = 0; k < from.cycles.size(); ++k) {
    const CycleResult& c = from.cycles[k];
    for (std::size_t i = c.first; i < c.last; ++i) {
      if (!moving(i)) continue;
      auto t = taken(scene, c, scene.data.readings[i], scale[k], late);
      if (!t) continue;
      t->cycle = k;
      visit(*t, scene.data.readings[i]);
    }
  }
}

Branches collect(const Source& from, bool late) {
  Branches b;
  each_taken(from, late, [&b](const Taken& t, const RunReading& r) {
    (t.up ? b.up : b.down).add(t.row.data(), t.fF);
    const double error = r.alignment_N();
    b.square_rate_error += error * error;
    ++b.counts;
  });
  return b;
}

double value_at(const std::vector<double>& coefficients, const Row& row) {
  double sum = 0;
  for (std::size_t i = 0; i <= kOrder; ++i) sum += coefficients[i] * row[i];
  return sum;
}

struct Loop {
  LeastSquares::Solution up, down;
  double variance = 0;
  double freedom = 0;  // of the standard errors
  double reading_error_fF = 0;  // of the largest gap, from the scatter of the readings alone
  std::string basis;
  std::vector<LoopPoint> points;
  std::size_t largest = 0;
  double area = 0, area_variance = 0;  // `area`: mean gap over the range, fF
};

std::optional<Loop> make_loop(const Branches& b, double peak_N) {
  auto up = b.up.solve(), down = b.down.solve();
  if (!up || !down || b.up.rows() < kLeastOfBranch || b.down.rows() < kLeastOfBranch) {
    return std::nullopt;
  }
  Loop loop;
  loop.variance = (up->residual_ss + down->residual_ss) / (up->freedom + down->freedom);
  Row row{};
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
  loop.freedom = up->freedom + down->freedom;
  loop.basis = "scatter about the branches";
  loop.reading_error_fF = loop.points[loop.largest].gap_se_fF;
  loop.up = std::move(*up);
  loop.down = std::move(*down);
  return loop;
}

// Contribution of one cycle to the coefficients of the branches. Where all cycles have the same
// readings this is the cycle's own branch less the common one, divided by the number of cycles.
struct CycleShare {
  Row up{}, down{};
  double span_fF = 0;  // its contribution to the span that the gap is divided by
  double explained = 0;  // part of the residual sum of squares that its own branches explain
};

std::vector<CycleShare> shares_of(const Source& from, const Loop& loop) {
  std::vector<CycleShare> scores(from.cycles.size()), shares(from.cycles.size());
  each_taken(from, false, [&](const Taken& t, const RunReading&) {
    const double residual = t.fF - value_at((t.up ? loop.up : loop.down).value, t.row);
    Row& score = t.up ? scores[t.cycle].up : scores[t.cycle].down;
    for (std::size_t i = 0; i <= kOrder; ++i) score[i] += t.row[i] * residual;
  });
  const auto solve = [](const LeastSquares::Solution& s, const Row& score, Row& share) {
    for (std::size_t i = 0; i <= kOrder; ++i) {
      for (std::size_t j = 0; j <= kOrder; ++j) {
        share[i] += s.unit_covariance[i * (kOrder + 1) + j] * score[j];
      }
    }
  };
  const auto cycles = static_cast<double>(scores.size());
  const double span = mean_height_fF(from.cycles);
  for (std::size_t k = 0; k < scores.size(); ++k) {
    shares[k].span_fF = (std::abs(from.cycles[k].delta_C_fF) - span) / cycles;
    solve(loop.up, scores[k].up, shares[k].up);
    solve(loop.down, scores[k].down, shares[k].down);
    for (std::size_t i = 0; i <= kOrder; ++i) {
      shares[k].explained +=
          cycles * (scores[k].up[i] * shares[k].up[i] + scores[k].down[i] * shares[k].down[i]);
    }
  }
  return shares;
}

// Variance of the gap, fF2. The gap is taken relative to the span, so that errors which both share
// cancel.
double variance_of_shares(const std::vector<CycleShare>& shares, const Row& row, double of_span) {
  double sum = 0;
  for (const CycleShare& s : shares) {
    double gap = -of_span * s.span_fF;
    for (std::size_t i = 0; i <= kOrder; ++i) gap += row[i] * (s.down[i] - s.up[i]);
    sum += gap * gap;
  }
  const auto n = static_cast<double>(shares.size());
  return sum * n / (n - 1);
}

// Sets the errors of the gap. The cycles are treated as a sample, like the slopes of repeats. The
// scatter of the readings takes over only where it gives the larger error, and never with two
// cycles. With one cycle its readings alone give the error, corrected for the correlation of
// neighbours.
void set_errors(const Source& from, Loop& loop) {
  const std::size_t cycles = from.cycles.size();
  if (cycles == 1) {
    const double wider = from.scene.correlation.widening();
    for (LoopPoint& p : loop.points) p.gap_se_fF *= wider;
    loop.area_variance *= wider * wider;
    loop.freedom = std::max(1.0, from.scene.correlation.freedom_of(loop.freedom));
    loop.basis = "scatter about the branches of one cycle: nothing is known of other cycles";
    return;
  }
  const auto shares = shares_of(from, loop);
  const double span = mean_height_fF(from.cycles);
  Row row{}, mean{};
  std::vector<double> errors;
  for (int k = 0; k < kGrid; ++k) {
    fill(kFrom + (kTo - kFrom) * k / (kGrid - 1), row);
    for (std::size_t i = 0; i <= kOrder; ++i) mean[i] += row[i] / kGrid;
    const LoopPoint& p = loop.points[static_cast<std::size_t>(k)];
    errors.push_back(std::sqrt(variance_of_shares(shares, row, (p.down_fF - p.up_fF) / span)));
  }
  // The scatter of the readings after the differences between cycles are taken out.
  double within = loop.up.residual_ss + loop.down.residual_ss;
  for (const CycleShare& s : shares) within -= s.explained;
  const double freedom =
      loop.freedom - 2 * static_cast<double>(kOrder + 1) * static_cast<double>(cycles - 1);
  const double part = freedom >= 5 ? std::max(0.0, within) / freedom / loop.variance : 0;
  for (LoopPoint& p : loop.points) p.gap_se_fF *= std::sqrt(part);
  loop.area_variance *= part;
  if (cycles > 2 && errors[loop.largest] < loop.points[loop.largest].gap_se_fF) {
    loop.freedom = freedom;
    return;
  }
  for (std::size_t k = 0; k < errors.size(); ++k) loop.points[k].gap_se_fF = errors[k];
  loop.area_variance = variance_of_shares(shares, mean, loop.area / span);
  loop.freedom = static_cast<double>(cycles) - 1;
  loop.basis = fmt::format("the gaps of {} cycles as a sample", cycles);
}

double gap_fF(const LoopPoint& p) {
  return p.down_fF - p.up_fF;
}

double mean_peak_N(const std::vector<CycleResult>& cycles) {
  double sum = 0;
  for (const CycleResult& c : cycles) sum += c.peak_force_N;
  return sum / static_cast<double>(cycles.size());
}

// A common error of the instant shifts loading and unloading apart by 2 (dC/dF) (dF/dt) u. The
// slope of the curve is that where the gap is largest, from both branches.
double alignment_fF(const Branches& b, const Loop& loop) {
  const LoopPoint& before = loop.points[loop.largest - (loop.largest > 0 ? 1 : 0)];
  const LoopPoint& after = loop.points[std::min(loop.largest + 1, loop.points.size() - 1)];
  const double slope = (after.up_fF - before.up_fF + after.down_fF - before.down_fF) / 2 /
                       (after.force_N - before.force_N);
  const double force = std::sqrt(b.square_rate_error / static_cast<double>(b.counts));
  return 2 * std::abs(slope) * force;
}

void fill_result(const Source& from, const Branches& b, const Loop& loop, Hysteresis& h) {
  const double span = mean_height_fF(from.cycles);
  const LoopPoint& at = loop.points[loop.largest];
  const double freedom = loop.freedom, confidence = from.scene.options.confidence;
  h.largest_gap.estimate =
      estimate(std::abs(gap_fF(at)) / span * 100, at.gap_se_fF / span * 100, freedom, confidence);
  h.area.estimate = estimate(loop.area / span * 100, std::sqrt(loop.area_variance) / span * 100,
                             freedom, confidence);
  h.largest_gap.rows = h.area.rows = b.counts;
  h.alignment_percent = alignment_fF(b, loop) / span * 100;
  // The largest of many points exceeds a limit by chance more often than a single one.
  const double noise = coverage_factor(0.99, freedom) * *h.largest_gap.estimate->standard_error;
  const double limit = std::hypot(noise, 2 * *h.alignment_percent);
  h.resolved = h.largest_gap.value() > limit;
  if (!h.resolved) {
    double& low = h.largest_gap.estimate->interval->front();
    low = std::min(low, 0.0);  // it is not known which branch lies above the other
    h.largest_gap.reason = fmt::format(
        "not resolved: noise and the instant of the readings alone can make {:.2g} %", limit);
  }
  if (from.cycles.size() == 1) {
    for (Metric* m : {&h.largest_gap, &h.area}) add_remark(m->reason, kOneCycle);
  }
  h.loop = loop.points;
  h.in_readings =
      h.largest_gap.value() >
      std::hypot(kInReadings * loop.reading_error_fF / span * 100, 2 * *h.alignment_percent);
  h.basis = loop.basis;
}

}  // namespace

Hysteresis calc_hysteresis(const Scene& scene, const CycleResults& results,
                           const HoldResults& holds) {
  const std::vector<CycleResult>& cycles = results.cycles;
  Hysteresis h;
  h.largest_gap = metric("hysteresis", "%", kLargestGap);
  h.area = metric("hysteresis_area", "%", kArea);
  const Source from{scene, cycles, holds};
  if (cycles.empty()) {
    h.largest_gap.reason = h.area.reason = "no loading was found";
    return h;
  }
  const double span = mean_height_fF(cycles), peak_N = mean_peak_N(cycles);
  const Branches b = collect(from, false);
  auto loop = make_loop(b, peak_N);
  if (!loop || span <= 0) {
    h.largest_gap.reason = h.area.reason =
        fmt::format("too few readings while the force grew or fell: {} and {}, it takes {} each",
                    b.up.rows(), b.down.rows(), kLeastOfBranch);
    return h;
  }
  set_errors(from, *loop);
  fill_result(from, b, *loop, h);
  for (Metric* m : {&h.largest_gap, &h.area}) add_remark(m->reason, results.why_left_out);
  if (const auto late = make_loop(collect(from, true), peak_N)) {
    h.uncorrected_percent = std::abs(gap_fF(late->points[late->largest])) / span * 100;
  }
  return h;
}

}  // namespace lcrig
