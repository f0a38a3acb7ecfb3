// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/sim_limits.hpp"

#include <algorithm>
#include <cmath>

namespace lcrig::frame_link {

namespace {

constexpr double kMaxStiffness_N_m = 1e8;
constexpr double kTravelSlack_m = 1e-10;  // below the resolution of any drive

}  // namespace

double felt_N(const PlantConfig& p) {
  return 5 * std::max(p.force_resolution_N, p.force_noise_N);
}

FrameCapabilities SimLimits::of_machine() const {
  const PlantConfig& p = scene_.config();
  if (settings_.declared) return *settings_.declared;
  FrameCapabilities c;
  c.motion = c.zero_force = c.zero_travel = true;
  c.device_stop = settings_.watch_period_s == 0;
  c.force_hold = settings_.force_hold;
  if (c.force_hold) {
    c.force_loop.emplace();
    c.force_loop->approach = Velocity::from_si(settings_.approach_m_s);
    c.force_loop->contact = Force::from_si(felt_N(p));
    c.force_loop->rate_max = ForceRate::from_si(settings_.loop_rate_max_N_s);
    c.force_loop->lag = from_seconds(settings_.loop_lag_s);
    // The shown force contains the noise of the cell, so the ripple includes it.
    c.force_loop->ripple = Force::from_si(settings_.loop_ripple_N + 5 * p.force_noise_N);
    c.force_loop->stiffness_max = Stiffness::from_si(kMaxStiffness_N_m);
  }
  c.force_max = Force::from_si(p.force_nominal_N);
  c.force_class = p.force_class;
  c.speed_min = Velocity::from_si(settings_.speed_min_m_s);
  c.speed_max = Velocity::from_si(p.speed_max_m_s);
  c.travel_min = Length::from_si(p.travel_min_m);
  c.travel_max = Length::from_si(p.travel_max_m);
  c.sample_rate_max_Hz = settings_.rate_max_Hz;
  c.reaction = from_seconds(p.drive_lag_s + settings_.watch_period_s);
  c.deceleration = Acceleration::from_si(p.deceleration_m_s2);
  c.travel_step = Length::from_si(p.travel_resolution_m);
  c.force_step = Force::from_si(p.force_resolution_N);
  c.filter = Duration::zero();  // this cell has none, and this drive turns round at once
  c.play = Length();
  return c;
}

Verdict SimLimits::set(const FrameLimits& l, double zero_m) {
  if (l.force_min >= l.force_max || l.travel_min >= l.travel_max || l.speed_max.si() <= 0) {
    return Refusal("bad_value", "an empty range");
  }
  const PlantConfig& p = scene_.config();
  const double low = l.travel_min.si() + zero_m, high = l.travel_max.si() + zero_m;
  if (low < p.travel_min_m - kTravelSlack_m || high > p.travel_max_m + kTravelSlack_m) {
    return Refusal("machine_limits", "travel beyond the machine's own limits");
  }
  if (std::max(-l.force_min.si(), l.force_max.si()) > p.force_nominal_N) {
    return Refusal("machine_limits", "force beyond the load cell");
  }
  if (l.speed_max.si() > p.speed_max_m_s * (1 + 1e-9)) {
    return Refusal("machine_limits", "speed beyond the machine's maximum");
  }
  limits_ = l;
  return std::nullopt;
}

Verdict SimLimits::check_motion(double target_m, double speed_m_s, double zero_m) const {
  const double speed = std::abs(speed_m_s);
  if (!(speed > 0)) return Refusal("bad_value", "speed must not be 0");
  if (speed > limits_->speed_max.si() * (1 + 1e-9)) return Refusal("limits", "speed beyond LIMITS");
  if (speed < settings_.speed_min_m_s * (1 - 1e-9)) {
    return Refusal("machine_limits", "slower than the machine can");
  }
  if (target_m < limits_->travel_min.si() - kTravelSlack_m ||
      target_m > limits_->travel_max.si() + kTravelSlack_m) {
    return Refusal("limits", "travel beyond LIMITS");
  }
  const PlantConfig& p = scene_.config();
  const double raw = target_m + zero_m;
  if (raw < p.travel_min_m - kTravelSlack_m || raw > p.travel_max_m + kTravelSlack_m) {
    return Refusal("machine_limits", "travel beyond the machine's own limits");
  }
  return std::nullopt;
}

Verdict SimLimits::check_force(double force_N) const {
  if (force_N < limits_->force_min.si() || force_N > limits_->force_max.si()) {
    return Refusal("limits", "force beyond LIMITS");
  }
  return std::nullopt;
}

// Beyond a force limit, only motion away from it is allowed.
Verdict SimLimits::check_direction(double shown_N, double direction) const {
  if (direction > 0 && shown_N > limits_->force_max.si() + kForceSlack_N) {
    return Refusal("limits", "the force is beyond force_max: move away first");
  }
  if (direction < 0 && shown_N < limits_->force_min.si() - kForceSlack_N) {
    return Refusal("limits", "the force is below force_min: move closer first");
  }
  return std::nullopt;
}

}  // namespace lcrig::frame_link
