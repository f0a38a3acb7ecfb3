// SPDX-License-Identifier: Apache-2.0
// A linear spring behind a gap, for which every answer is known in closed form. The world of
// FrameBench.
#pragma once

#include <algorithm>
#include <cmath>

#include "drivers/zwick/sim.hpp"

namespace lcrig {

class LinearScene final : public FrameScene {
 public:
  explicit LinearScene(double stiffness_N_m = 10'000, PlantConfig config = quiet())
      : k_(stiffness_N_m), config_(config) {}

  static PlantConfig quiet() {
    PlantConfig c;
    c.contact_travel_m = 1e-3;
    c.force_noise_N = 0;
    return c;
  }

  const PlantConfig& config() const override { return config_; }
  double travel_m(MonoTime t) const override {
    const double s = std::max(0.0, to_seconds(t - start_));
    if (s >= straight_s_ + brake_s_) return end_;
    const double braked = std::max(0.0, s - straight_s_);
    const double braking = std::copysign(config_.deceleration_m_s2 / 2 * braked * braked, v_);
    return x0_ + v_ * s - braking;
  }
  double force_N(MonoTime t) const override { return force_at_travel_N(travel_m(t)); }
  double force_at_travel_N(double x) const override {
    return std::max(0.0, k_ * (x - config_.contact_travel_m));
  }
  void move_to(MonoTime t, double x, double speed) override {
    const double from = travel_m(t);
    set(t, from, x < from ? -speed : speed, std::abs(x - from) / speed, 0, x);
  }
  void ramp_force(MonoTime t, double force, double rate) override {
    move_to(t, config_.contact_travel_m + force / k_, rate / k_);
  }
  void halt(MonoTime t) override {
    ++halts;
    const double s = to_seconds(t - start_);
    const double from = travel_m(t);
    if (s >= straight_s_) return set(t, from, 0, 0, 0, from);
    const double brake_s = std::abs(v_) / config_.deceleration_m_s2;
    const double end = from + v_ * (config_.drive_lag_s + brake_s / 2);
    set(t, from, v_, config_.drive_lag_s, brake_s, end);
  }
  std::optional<MonoTime> arrival() const override {
    if (v_ == 0) return std::nullopt;
    return start_ + from_seconds(straight_s_ + brake_s_);
  }
  std::optional<MonoTime> force_crossing(double force, MonoTime from, MonoTime to) const override {
    const double a = force_N(from) - force, b = force_N(to) - force;
    if (a == 0) return from;
    if (a * b > 0) return std::nullopt;
    MonoTime low = from, high = to;
    while (high - low > Duration(1)) {
      const MonoTime mid = low + (high - low) / 2;
      ((force_N(mid) - force) * a > 0 ? low : high) = mid;
    }
    return high;
  }

  int halts = 0;

 private:
  void set(MonoTime t, double x0, double v, double straight_s, double brake_s, double end) {
    start_ = t;
    x0_ = x0;
    v_ = v;
    straight_s_ = straight_s;
    brake_s_ = brake_s;
    end_ = end;
  }

  double k_;  // N/m
  PlantConfig config_;
  MonoTime start_{};
  double x0_ = 0, v_ = 0, straight_s_ = 0, brake_s_ = 0, end_ = 0;  // m, m/s, s, s, m
};

}  // namespace lcrig
