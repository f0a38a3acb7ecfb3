// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/rest_measurement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

namespace lcrig {

namespace {

constexpr double kLeastDigit_N = 1e-9;  // no tolerance: below the resolution of any cell
constexpr double kMiddleOfSteps = 0.954;  // no tolerance: sqrt(2) 0.6745, for a normal distribution

// The straight line through values at given times.
struct Line {
  double time_s = 0, value = 0, slope = 0;  // middle of the line, and its slope
};
Line line_through(std::span<const double> t, std::span<const double> y) {
  const auto n = static_cast<double>(t.size());
  Line line;
  double tt = 0, ty = 0;
  for (std::size_t i = 0; i < t.size(); ++i) line.time_s += t[i] / n, line.value += y[i] / n;
  for (std::size_t i = 0; i < t.size(); ++i) {
    tt += (t[i] - line.time_s) * (t[i] - line.time_s);
    ty += (t[i] - line.time_s) * (y[i] - line.value);
  }
  if (tt > 0) line.slope = ty / tt;
  return line;
}

std::vector<double> residuals(const std::vector<double>& t, const std::vector<double>& y) {
  const Line line = line_through(t, y);
  std::vector<double> out(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) {
    out[i] = y[i] - line.value - line.slope * (t[i] - line.time_s);
  }
  return out;
}

double mean_square(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return v.empty() ? 0 : sum / static_cast<double>(v.size());
}

}  // namespace

double sure_scatter_N(double scatter_N, double freedoms) {
  return freedoms > 0 ? scatter_N * (1 + kFewSamples / freedoms) : scatter_N;
}

double scatter_anew(double freedoms) {
  return std::exp(kAgainSigmas / std::sqrt(std::max(1.0, freedoms - 1)));
}

void RestMeasurement::add(std::span<const FrameSample> samples) {
  samples_ += std::ssize(samples);
  for (const FrameSample& s : samples) {
    moving_ = moving_ || (s.flags & frame_flag::kMoving) != 0;
    if (!begin_) begin_ = s.received;
    const double t = to_seconds(s.received - *begin_);
    if (s.travel_m) {
      travel_min_m_ = travels_ == 0 ? *s.travel_m : std::min(travel_min_m_, *s.travel_m);
      travel_max_m_ = travels_ == 0 ? *s.travel_m : std::max(travel_max_m_, *s.travel_m);
      travel_sum_m_ += *s.travel_m;
      ++travels_;
      travels_seen_.add(t, *s.travel_m);
    }
    if (!s.force_N) continue;
    compare_digits(*s.force_N);
    forces_seen_.add(t, *s.force_N);
    const double dt = t - time_.mean;
    time_.add(t);
    force_.add(*s.force_N);
    products_ += dt * (*s.force_N - force_.mean);
  }
}

void RestMeasurement::compare_digits(double force_N) {
  const double step = last_N_ ? std::abs(force_N - *last_N_) : 0;
  const bool same = last_N_ && *last_N_ == force_N;
  if (last_N_ && !same) ++different_;
  run_ = same ? run_ + 1 : 1;
  longest_run_ = std::max(longest_run_, run_);
  if (step > kLeastDigit_N && (digit_N_ == 0 || step < digit_N_)) digit_N_ = step;
  last_N_ = force_N;
}

double RestMeasurement::scatter_N() const {
  return forces() > 1 ? std::sqrt(force_.variance()) : 0;
}

void RestMeasurement::know_drift(const RestMeasurement& before, Duration ago) {
  const double s = to_seconds(ago);
  known_drift_ = {(force_N() - before.force_N()) / s, std::hypot(error_N(), before.error_N()) / s};
}

double RestMeasurement::drift_N_s() const {
  if (known_drift_) return known_drift_->drift_N_s;
  return forces() > 2 && time_.sum_squares > 0 ? products_ / time_.sum_squares : 0;
}

double RestMeasurement::drift_error_N_s() const {
  if (known_drift_) return known_drift_->error_N_s;
  const double tt = time_.sum_squares;
  if (forces() < 3 || !(tt > 0)) return std::numeric_limits<double>::infinity();
  const double left = std::max(0.0, force_.sum_squares - products_ * products_ / tt);
  const double error = std::sqrt(left / static_cast<double>(forces() - 2) / tt);
  return std::max(correlation() * error, disunity_N_s());
}

// Compares the drift of both halves with the whole. A true drift is the same; by chance the mean of
// the halves deviates by sqrt(3) of its own standard errors.
double RestMeasurement::disunity_N_s() const {
  const std::span t(forces_seen_.t_s), y(forces_seen_.value);
  const std::size_t half = t.size() / 2;
  if (half < static_cast<std::size_t>(kInBlock.count())) return 0;
  const double first = line_through(t.first(half), y.first(half)).slope;
  const double second = line_through(t.subspan(half), y.subspan(half)).slope;
  return std::abs(drift_N_s() - (first + second) / 2) / std::numbers::sqrt3;
}

// Detects correlated samples: hum that the sampling turns into a slow wave looks like a drift. The
// means of batches then scatter more than those of independent samples (batch means).
double RestMeasurement::correlation() const {
  const std::size_t n = forces_seen_.value.size();
  const std::size_t batches = std::min<std::size_t>(kBlocks.count(), n / kInBlock.count());
  if (batches < 3) return 1;
  const std::vector<double> left = residuals(forces_seen_.t_s, forces_seen_.value);
  const double each = mean_square(left);
  if (!(each > 0)) return 1;
  const std::size_t size = n / batches;
  std::vector<double> means(batches, 0.0);
  for (std::size_t i = 0; i < batches * size; ++i) {
    means[i / size] += left[i] / static_cast<double>(size);
  }
  return std::max(1.0, std::sqrt(mean_square(means) * static_cast<double>(size) / each));
}

double RestMeasurement::travel_scatter_m() const {
  const auto is_end = [this](double x) { return x == travel_min_m_ || x == travel_max_m_; };
  if (std::ranges::all_of(travels_seen_.value, is_end)) return 0;
  return std::sqrt(mean_square(residuals(travels_seen_.t_s, travels_seen_.value)));
}

std::optional<double> RestMeasurement::travel_m() const {
  if (travels_ == 0) return std::nullopt;
  return travel_sum_m_ / static_cast<double>(travels_);
}

// Standard deviation from the steps between samples. Neither a steady motion nor a single jump adds
// to it.
double RestMeasurement::travel_jitter_m() const {
  const std::vector<double>& x = travels_seen_.value;
  if (std::ssize(x) < kRestSamples.count()) return 0;
  std::vector<double> steps(x.size());
  std::adjacent_difference(x.begin(), x.end(), steps.begin());
  steps.erase(steps.begin());  // the first value itself
  const double usual = upper_median(steps);
  for (double& step : steps) step = std::abs(step - usual);
  return upper_median(steps) / kMiddleOfSteps;
}

bool RestMeasurement::stands() const {
  const double jitters_m = std::min(kNoiseSigmas * travel_jitter_m(), kStanding_m.value);
  return !moving_ && travel_max_m_ - travel_min_m_ <= kStanding_m + jitters_m;
}

}  // namespace lcrig
