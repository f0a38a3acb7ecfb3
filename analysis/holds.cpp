// SPDX-License-Identifier: Apache-2.0
// Finds stretches of steady load and computes creep, drift and settling from them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/least_squares.hpp"
#include "analysis/metrics.hpp"

namespace lcrig {

namespace {

constexpr double kForceBand = 0.02;  // of the force above rest; within it a load is steady
// At a held travel the force relaxes. A larger change than this share is a motion.
constexpr double kRelaxation = 0.15;
constexpr double kTravelBand = 0.005;  // share of the cycle's travel
constexpr double kSteady = 0.005;  // largest relative change of a held force over the stretch
constexpr double kTravelResolution_m = 1e-9;
constexpr double kLeastTime_s = 2;
constexpr std::int64_t kLeastReadings = 10;
constexpr double kResolved = 3.3;  // standard errors: chance exceeds it once in a thousand
constexpr double kSettled = 0.02;  // share of the change from rest within which C has settled
constexpr std::size_t kMaxHolds = 1000;
constexpr int kTimeConstants = 60;

struct HoldStretch {
  std::size_t first = 0, last = 0;  // [first, last) of the readings
};

double travel_range(const Scene& scene, const Loading& c) {
  float low = 0, high = 0;
  bool any = false;
  for (std::size_t i = c.first; i < c.last; ++i) {
    const RunReading& r = scene.data.readings[i];
    if (!r.has_travel()) continue;
    low = any ? std::min(low, r.travel_m) : r.travel_m;
    high = any ? std::max(high, r.travel_m) : r.travel_m;
    any = true;
  }
  return high - low;
}

bool stays(const Scene& scene, const RunReading& from, const RunReading& r, double range_m) {
  const double force = scene.above_rest_N(from);
  const double change = std::abs(r.force_N - from.force_N);
  if (change <= std::max(kForceBand * force, 6 * scene.force_noise_N)) return true;
  return from.has_travel() && r.has_travel() && change <= kRelaxation * force &&
         std::abs(r.travel_m - from.travel_m) <= kTravelBand * range_m;
}

// Cuts the end of a ramp off the front of a hold, because it is no creep: the readings from which
// the force still changes by more than a twentieth in a second.
void cut_ramp(const Scene& scene, HoldStretch& s) {
  const auto& readings = scene.data.readings;
  const std::size_t half = s.first + (s.last - s.first) / 2;
  while (s.first < half) {
    const RunReading &a = readings[s.first], &b = readings[s.first + 1];
    if (a.has_force() && b.has_force() && scene.uses(a) && scene.uses(b)) {
      const double noise = 6 * scene.force_noise_N;
      const double allowed = 0.05 * scene.above_rest_N(a) * (b.t_s - a.t_s) + noise;
      if (std::abs(b.force_N - a.force_N) <= allowed) return;
    }
    ++s.first;
  }
}

double trend(const std::vector<LinePoint>& points, double span, double& error) {
  const auto line = fit_line(points);
  if (!line || line->points < 3) return error = 0;
  error = line->slope_se() * span;
  return line->slope * span;
}

// A slow ramp also stays within the band for a while, but its force and travel both keep changing.
bool is_held(const Scene& scene, const HoldStretch& s) {
  const auto& readings = scene.data.readings;
  std::vector<LinePoint> force, travel;
  for (std::size_t i = s.first; i < s.last; ++i) {
    const RunReading& r = readings[i];
    if (!r.has_force() || !scene.uses(r)) continue;
    force.push_back({r.t_s, scene.above_rest_N(r), 1});
    if (r.has_travel()) travel.push_back({r.t_s, r.travel_m, 1});
  }
  const double span = readings[s.last - 1].t_s - readings[s.first].t_s;
  double error = 0;
  const double force_change = std::abs(trend(force, span, error));
  if (force_change <= std::max(kSteady * std::abs(force.front().y), 3 * error)) return true;
  const double travel_change = std::abs(trend(travel, span, error));
  return travel.size() == force.size() && travel_change <= 3 * error + kTravelResolution_m;
}

std::vector<HoldStretch> find_stretches(const Scene& scene, const Loading& c) {
  std::vector<HoldStretch> out;
  const auto& readings = scene.data.readings;
  const double range = travel_range(scene, c);
  HoldStretch s{c.first, c.first};
  const auto close = [&] {
    if (s.last - s.first >= static_cast<std::size_t>(kLeastReadings)) cut_ramp(scene, s);
    if (s.last - s.first < static_cast<std::size_t>(kLeastReadings)) return;
    if (readings[s.last - 1].t_s - readings[s.first].t_s < kLeastTime_s) return;
    if (is_held(scene, s)) out.push_back(s);
  };
  for (std::size_t i = c.first; i < c.last; ++i) {
    const RunReading& r = readings[i];
    if (!r.has_force() || !scene.uses(r)) continue;
    if (s.last > s.first && !stays(scene, readings[s.first], r, range)) {
      close();
      s.first = i;
    }
    if (s.last <= s.first) s.first = i;
    s.last = i + 1;
  }
  close();
  return out;
}

// The readings of a stretch: time since its beginning (half a reading before the first) and C, fF.
struct Series {
  std::vector<double> t_s, fF;
};

Series series_of(const Scene& scene, const HoldStretch& s, HoldResult& h) {
  Series out;
  RunningMean force, head, tail, capacitance;
  const auto& readings = scene.data.readings;
  const double span = readings[s.last - 1].t_s - readings[s.first].t_s;
  const double begin = readings[s.first].t_s - span / static_cast<double>(s.last - s.first) / 2;
  for (std::size_t i = s.first; i < s.last; ++i) {
    const RunReading& r = readings[i];
    if (!r.has_force() || !scene.uses(r)) continue;
    out.t_s.push_back(r.t_s - begin);
    out.fF.push_back(scene.fF(r));
    force.add(scene.above_rest_N(r));
    capacitance.add(out.fF.back());
    if (r.t_s - begin < 0.1 * span) head.add(scene.above_rest_N(r));
    if (r.t_s - begin > 0.9 * span) tail.add(scene.above_rest_N(r));
  }
  h.begin_s = begin;
  h.end_s = readings[s.last - 1].t_s;
  h.mean_force_N = force.mean;
  h.mean_fF = capacitance.mean;
  h.readings = std::ssize(out.t_s);
  if (head.count > 0 && tail.count > 0) h.force_change_percent = (tail.mean / head.mean - 1) * 100;
  return out;
}

void fit_log_time(const Series& s, HoldResult& h) {
  std::vector<LinePoint> points;
  points.reserve(s.t_s.size());
  for (std::size_t i = 0; i < s.t_s.size(); ++i) {
    points.push_back({std::log10(s.t_s[i]), s.fF[i], 1});
  }
  const auto line = fit_line(points);
  if (!line || line->points < 3) return;
  const double se = line->slope_se();
  const double decades = points.back().x - points.front().x;
  h.per_decade_fF = line->slope;
  h.per_decade_se_fF = se;
  h.change_fF = line->slope * decades;
  h.change_se_fF = se * decades;
  h.resolved = std::abs(h.change_fF) > kResolved * h.change_se_fF;
}

void fit_drift(const Series& s, HoldResult& h) {
  std::vector<LinePoint> points;
  for (std::size_t i = s.t_s.size() / 2; i < s.t_s.size(); ++i) {
    points.push_back({s.t_s[i], s.fF[i], 1});
  }
  const auto line = fit_line(points);
  if (!line || line->points < 3) return;
  h.drift_fF_per_s = line->slope;
  h.drift_se_fF_per_s = line->slope_se();
}

// Fits C = end + step exp(-t/tau). This is linear for a given tau, so tau is searched on a grid.
void fit_settling(const Series& s, double rest_fF, HoldResult& h) {
  const double longest = s.t_s.back(), shortest = std::max(s.t_s.front(), longest * 1e-3);
  std::optional<LeastSquares::Solution> best;
  double tau = 0;
  bool inside = false;
  for (int k = 0; k < kTimeConstants; ++k) {
    const double t = shortest * std::pow(longest / shortest, k / (kTimeConstants - 1.0));
    LeastSquares fit(2);
    for (std::size_t i = 0; i < s.t_s.size(); ++i) {
      const double row[2] = {1, std::exp(-s.t_s[i] / t)};
      fit.add(row, s.fF[i]);
    }
    auto solution = fit.solve();
    if (!solution || (best && solution->residual_ss >= best->residual_ss)) continue;
    inside = k > 0 && k + 1 < kTimeConstants;
    tau = t;
    best = std::move(solution);
  }
  if (!best || !inside) {
    h.reason = "one exponential does not describe the creep within the hold";
    return;
  }
  h.time_constant_s = tau;
  const double band = kSettled * std::abs(best->value[0] - rest_fF);
  const double step = std::abs(best->value[1]);
  const double variance = best->residual_ss / std::max(1.0, best->freedom);
  const double step_se = std::sqrt(variance * best->unit_covariance[3]);
  // What settled before the first reading, or by less than the noise, has no known time.
  if (!(step - band > kResolved * step_se)) {
    h.reason = fmt::format(
        "settling is not resolved: the creep within the hold, {:.3g} fF, is not "
        "beyond 2 % of the change from rest and the noise",
        step);
    return;
  }
  h.settling_s = tau * std::log(step / band);
}

HoldResult result_of(const Scene& scene, const RestedLoading& c, const HoldStretch& s) {
  HoldResult h;
  h.cycle = c.number;
  h.first = s.first;
  h.last = s.last;
  h.step_id = scene.data.steps[scene.data.readings[s.first].step];
  const Series series = series_of(scene, s, h);
  fit_log_time(series, h);
  fit_drift(series, h);
  if (h.resolved) {
    fit_settling(series, c.rest_pF * 1e3, h);
  } else {
    h.reason = "no creep beyond the noise of the readings";
  }
  return h;
}

// Change of delta C per decade of time: the mean over the holds, weighted by their errors.
void calc_creep(const Scene& scene, HoldResults& out) {
  RunningMean unweighted;
  double weights = 0, sum = 0, squares = 0;
  for (const HoldResult& h : out.holds) {
    if (!h.per_decade_se_fF || *h.per_decade_se_fF <= 0 || h.cycle == 0) continue;
    const auto& c = scene.loadings[static_cast<std::size_t>(h.cycle - 1)];
    const double delta = h.mean_fF - c.rest_pF * 1e3 + scene.drift.at(c.rest_s);
    if (delta == 0) continue;
    const double se = std::abs(*h.per_decade_se_fF / delta) * 100;
    const double y = *h.per_decade_fF / delta * 100, w = 1 / (se * se);
    weights += w;
    sum += w * y;
    squares += w * y * y;
    unweighted.add(y);
    out.creep.rows += h.readings;
  }
  if (unweighted.count == 0) {
    out.creep.reason = "no steady load of 2 s and ten readings";
    return;
  }
  const double mean = sum / weights;
  const auto freedom = static_cast<double>(unweighted.count - 1);
  // The scatter between holds counts where it exceeds the errors within them (Birge's ratio).
  const double birge = freedom > 0 ? std::max(1.0, (squares - sum * mean) / freedom) : 1;
  const bool between = birge > 1;
  out.creep.estimate = estimate(mean, std::sqrt(birge / weights),
                                between ? freedom : std::numeric_limits<double>::infinity(),
                                scene.options.confidence);
}

// Creep that one of many holds shows may be chance, so more than half of them must show it.
void calc_settling(double confidence, HoldResults& out) {
  RunningMean s;
  std::int64_t rows = 0;
  for (const HoldResult& h : out.holds) {
    if (!h.settling_s) continue;
    s.add(*h.settling_s);
    rows += h.readings;
  }
  if (out.holds.empty()) {
    out.settling.reason = "no steady load of 2 s and ten readings";
    return;
  }
  if (2 * s.count <= std::ssize(out.holds)) {
    out.settling.reason = fmt::format(
        "not resolved: {} of {} holds show creep beyond 2 % and their noise that one exponential "
        "describes",
        s.count, out.holds.size());
    return;
  }
  out.settling.rows = rows;
  if (s.count < 2) out.settling.reason = "one hold: no scatter";
  out.settling.estimate =
      s.count < 2 ? Estimate(s.mean)
                  : estimate(s.mean, s.mean_se(), static_cast<double>(s.count - 1), confidence);
}

}  // namespace

HoldResults calc_holds(const Scene& scene) {
  HoldResults out;
  out.creep = metric("creep", "% per decade",
                     "slope of C against the logarithm of time under steady load, over delta C of "
                     "that load; mean over the holds, weighted with their standard errors");
  out.settling = metric("settling_time", "s",
                        "time until C stays within 2 % of its final change from rest, from one "
                        "exponential through each hold that shows creep; mean over the holds");
  for (const RestedLoading& c : scene.loadings) {
    for (const HoldStretch& s : find_stretches(scene, c)) {
      if (out.holds.size() >= kMaxHolds) {
        ++out.holds_left_out;
      } else {
        out.holds.push_back(result_of(scene, c, s));
      }
    }
  }
  calc_creep(scene, out);
  calc_settling(scene.options.confidence, out);
  return out;
}

}  // namespace lcrig
