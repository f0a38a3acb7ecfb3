// SPDX-License-Identifier: Apache-2.0
#include "protocols/watch/guard.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocols/watch/rest.hpp"

namespace lcrig {

namespace {

constexpr double kUnbounded = 1e9;

}  // namespace

void Guard::set_rest_force(double force_N, double noise_N) {
  offset_N_ = force_N < -kNoiseSigmas * noise_N ? force_N : 0;
}

void Guard::set_zero_under_load(double hidden_N) {
  if (distrusted_) return;
  limits_.force_min_N -= hidden_N - std::exchange(hidden_N_, hidden_N);
}

void Guard::distrust_zero(double cell_N) {
  distrusted_ = true;
  offset_N_ = 0;
  limits_.force_min_N = -cell_N;
  limits_.force_max_N = cell_N;
}

void Guard::allow_return(double noise_N) {
  mode_ = Mode::returning;
  noise_N_ = noise_N;
  stood_m_ = last_travel_m_;
}

void Guard::take_standstill(std::optional<double> force_N, std::optional<double> travel_m) {
  if (mode_ == Mode::returning) return;
  if (force_N) last_force_N_ = force_N;
  if (travel_m) last_travel_m_ = travel_m;
  peak_force_N_ = std::max(peak_force_N_, force_N.value_or(0));
}

std::optional<std::string> Guard::check(const FrameSample& sample) {
  const bool overload = (sample.flags & frame_flag::kForceOverload) != 0;
  if (sample.force_N) {
    last_ = sample.received;  // a sample without a force does not count
    // On the way back the largest force is that at its beginning. After an overload it is the first
    // force that the cell shows again.
    const bool unknown = mode_ == Mode::returning && !last_force_N_;
    if (mode_ != Mode::returning || unknown) {
      peak_force_N_ = std::max(peak_force_N_, *sample.force_N);
    }
  }
  if (sample.force_N || overload) last_force_N_ = sample.force_N;
  if (sample.travel_m) last_travel_m_ = sample.travel_m, travel_seen_ = sample.received;
  if (mode_ == Mode::stopping) return std::nullopt;
  if (overload) {
    if (mode_ == Mode::watching) return "the force is beyond the load cell";
    last_ = sample.received;
    return check_blind(sample);
  }
  if (mode_ == Mode::returning && distrusted_) return check_blind(sample);
  const bool mute = !sample.force_N && last_ && sample.received - *last_ > stale_after_;
  if (mode_ == Mode::returning && mute) return check_blind(sample);
  if (sample.force_N) {
    if (auto why = check_force(*sample.force_N)) return why;
  }
  if (auto why = check_travel_age(sample.received)) return why;
  return sample.travel_m ? check_travel(*sample.travel_m) : std::nullopt;
}

std::optional<std::string> Guard::check_force(double force_N) const {
  double most = force_max_N();
  if (mode_ == Mode::returning) {
    most = std::max(most, (1 + cell_.part()) * peak_force_N_ + kSampleSigmas * noise_N_);
  }
  if (force_N >= limits_.force_min_N && force_N <= most) return std::nullopt;
  if (mode_ == Mode::returning && force_N > most) {
    return fmt::format("force {:.4f} N rises on the way back, which began at {:.4f} N", force_N,
                       peak_force_N_);
  }
  return fmt::format("force {:.4f} N is outside the limits {:.4f} to {:.4f} N", force_N,
                     limits_.force_min_N, force_max_N());
}

// Notices samples without travel, because limits of travel and gap could not be checked.
std::optional<std::string> Guard::check_travel_age(MonoTime now) const {
  if (!watch_age_ || mode_ != Mode::watching || !travel_seen_) return std::nullopt;
  const Duration age = now - *travel_seen_;
  if (age <= 2 * stale_after_) return std::nullopt;
  return fmt::format("no travel in the samples for {:.2f} s", to_seconds(age));
}

void Guard::zero_travel(double travel_m) {
  limits_.zero_travel(travel_m);
  if (stood_m_) *stood_m_ -= travel_m;
  old_zero_m_ = travel_m;
}

std::optional<std::string> Guard::check_travel(double travel_m) {
  if (old_zero_m_ && std::abs(travel_m - *old_zero_m_) <= kStanding_m) return std::nullopt;
  old_zero_m_.reset();
  double low = limits_.travel_min_m.value_or(-kUnbounded);
  double high = limits_.travel_max_m.value_or(kUnbounded);
  if (mode_ == Mode::returning && stood_m_) {
    low = std::min(low, *stood_m_ - kStanding_m);
    high = std::max(high, *stood_m_ + kStanding_m);
  }
  if (travel_m >= low && travel_m <= high) return std::nullopt;
  return fmt::format("travel {:.4f} mm is outside the limits {:.4f} to {:.4f} mm", travel_m * 1e3,
                     limits_.travel_min_m.value_or(-kUnbounded) * 1e3,
                     limits_.travel_max_m.value_or(kUnbounded) * 1e3);
}

// Without a valid force, only motion away from the specimen is certain to unload it.
std::optional<std::string> Guard::check_blind(const FrameSample& sample) const {
  const bool away = sample.travel_m && stood_m_ && *sample.travel_m <= *stood_m_ + kStanding_m;
  if (away) return std::nullopt;
  return "the load cell shows no force that counts, and the frame does not move away from the "
         "specimen";
}

std::optional<std::string> Guard::check_age(MonoTime now) const {
  if (!watch_age_ || !last_ || now - *last_ <= stale_after_) return std::nullopt;
  // On the way back the travel alone is sufficient.
  if (mode_ == Mode::returning && travel_seen_ && now - *travel_seen_ <= stale_after_) {
    return std::nullopt;
  }
  return fmt::format("no force sample for {:.2f} s", to_seconds(now - *last_));
}

}  // namespace lcrig
