// SPDX-License-Identifier: Apache-2.0
#include "protocols/rest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lcrig {

namespace {

constexpr double kLeastStep_m = 1e-10;  // below any drive's resolution: rounding
constexpr double kLeastDigit_N = 1e-9;  // below any cell's

}  // namespace

void Rest::add(std::span<const FrameSample> samples) {
  for (const FrameSample& s : samples) {
    moving_ = moving_ || (s.flags & frame_flag::kMoving) != 0;
    if (s.travel_m) {
      travel_min_m_ = travels_ == 0 ? *s.travel_m : std::min(travel_min_m_, *s.travel_m);
      travel_max_m_ = travels_ == 0 ? *s.travel_m : std::max(travel_max_m_, *s.travel_m);
      travel_sum_m_ += *s.travel_m;
      ++travels_;
    }
    if (!s.force_N) continue;
    compare_digits(*s.force_N);
    ++n_;
    if (!begin_) begin_ = s.received;
    const double t = to_seconds(s.received - *begin_), n = static_cast<double>(n_);
    const double d = *s.force_N - mean_, dt = t - time_mean_s_;
    mean_ += d / n;
    time_mean_s_ += dt / n;
    squares_ += d * (*s.force_N - mean_);
    time_squares_ += dt * (t - time_mean_s_);
    products_ += dt * (*s.force_N - mean_);
  }
}

void Rest::compare_digits(double force_N) {
  const double step = last_N_ ? std::abs(force_N - *last_N_) : 0;
  const bool same = last_N_ && *last_N_ == force_N;
  if (last_N_ && !same) ++different_;
  run_ = same ? run_ + 1 : 1;
  longest_run_ = std::max(longest_run_, run_);
  if (step > kLeastDigit_N && (digit_N_ == 0 || step < digit_N_)) digit_N_ = step;
  last_N_ = force_N;
}

double Rest::scatter_N() const {
  return n_ > 1 ? std::sqrt(squares_ / static_cast<double>(n_ - 1)) : 0;
}

double Rest::error_N() const {
  return n_ > 0 ? scatter_N() / std::sqrt(static_cast<double>(n_)) : 0;
}

void Rest::know_drift(const Rest& before, Duration ago) {
  const double s = to_seconds(ago);
  known_drift_N_s_ = (force_N() - before.force_N()) / s;
  known_drift_error_N_s_ = std::hypot(error_N(), before.error_N()) / s;
}

double Rest::drift_N_s() const {
  if (known_drift_N_s_) return *known_drift_N_s_;
  return n_ > 2 && time_squares_ > 0 ? products_ / time_squares_ : 0;
}

double Rest::drift_error_N_s() const {
  if (known_drift_N_s_) return known_drift_error_N_s_;
  if (n_ < 3 || !(time_squares_ > 0)) return std::numeric_limits<double>::infinity();
  const double left = std::max(0.0, squares_ - products_ * products_ / time_squares_);
  return std::sqrt(left / static_cast<double>(n_ - 2) / time_squares_);
}

bool Rest::drifts() const {
  return std::abs(drift_N_s()) > kSureOfDrift * drift_error_N_s();
}

std::optional<double> Rest::travel_m() const {
  if (travels_ == 0) return std::nullopt;
  return travel_sum_m_ / static_cast<double>(travels_);
}

bool Rest::stands() const {
  return !moving_ && travel_max_m_ - travel_min_m_ <= kStanding_m;
}

std::string Rest::to_json_text() const {
  std::string text = fmt::format(R"({{"force_N":{},"scatter_N":{},"samples":{}}})", force_N(),
                                 scatter_N(), forces());
  if (const auto t = travel_m()) text.insert(text.size() - 1, fmt::format(R"(,"travel_m":{})", *t));
  return text;
}

void TravelStep::add(std::optional<double> travel_m) {
  if (!travel_m) return;
  const double step = last_m_ ? std::abs(*travel_m - *last_m_) : 0;
  last_m_ = travel_m;
  if (step > kLeastStep_m && (!step_m_ || step < *step_m_)) step_m_ = step;
}

}  // namespace lcrig
