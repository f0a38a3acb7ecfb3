// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/sim_machine.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lcrig::frame_link {

namespace {

constexpr double kHoldTime_s = 0.1;  // a force hold reaches its force within this
constexpr double kMinRate_N_s = 1e-3;
constexpr double kMaxStiffness_N_m = 1e8;
constexpr double kTravelSlack_m = 1e-10;  // below any drive's resolution

// A multiple of the resolution, as close as a double can be to its decimal form.
double quantise(double value, double resolution) {
  if (resolution <= 0) return value;
  const double steps = std::round(value / resolution);
  const double per_unit = std::round(1 / resolution);
  const bool decimal = resolution < 1 && std::abs(per_unit * resolution - 1) < 1e-9;
  return decimal ? steps / per_unit : steps * resolution;
}

double sign(double v) {
  return v < 0 ? -1.0 : 1.0;
}

}  // namespace

SimMachine::SimMachine(FrameScene& scene, const ZwickSimSettings& settings)
    : scene_(scene), settings_(settings), random_(settings.seed) {}

FrameCapabilities SimMachine::capabilities() const {
  const PlantConfig& p = scene_.config();
  if (settings_.declared) return *settings_.declared;
  FrameCapabilities c;
  c.motion = c.zero_force = c.zero_travel = true;
  c.device_stop = settings_.watch_period_s == 0;
  c.force_hold = settings_.force_hold;
  if (c.force_hold) {
    c.force_loop.emplace();
    c.force_loop->approach = Velocity::from_si(settings_.approach_m_s);
    c.force_loop->contact = Force::from_si(contact_N());
    c.force_loop->rate_max = ForceRate::from_si(settings_.loop_rate_max_N_s);
    c.force_loop->lag = from_seconds(settings_.loop_lag_s);
    // What wavers is the cell, too: as it shows it.
    c.force_loop->ripple = Force::from_si(settings_.loop_ripple_N + 5 * p.force_noise_N);
    c.force_loop->stiffness_max = Stiffness::from_si(kMaxStiffness_N_m);
  }
  c.force_max = Force::from_si(p.force_nominal_N);
  c.speed_min = Velocity::from_si(settings_.speed_min_m_s);
  c.speed_max = Velocity::from_si(p.speed_max_m_s);
  c.travel_min = Length::from_si(p.travel_min_m);
  c.travel_max = Length::from_si(p.travel_max_m);
  c.sample_rate_max_Hz = settings_.rate_max_Hz;
  c.reaction = from_seconds(p.drive_lag_s + settings_.watch_period_s);
  c.deceleration = Acceleration::from_si(p.deceleration_m_s2);
  return c;
}

Verdict SimMachine::set_limits(MonoTime, const FrameLimits& l) {
  if (is_moving()) return Refusal("busy", "limits change only while standing");
  if (l.force_min >= l.force_max || l.travel_min >= l.travel_max || l.speed_max.si() <= 0) {
    return Refusal("bad_value", "an empty range");
  }
  const PlantConfig& p = scene_.config();
  const double low = l.travel_min.si() + travel_zero_m_, high = l.travel_max.si() + travel_zero_m_;
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

Verdict SimMachine::check_motion(double target_m, double speed_m_s) const {
  if (!limits_) return Refusal("not_armed", "send LIMITS first");
  if (is_moving()) return Refusal("busy", "a motion is going on");
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
  const double raw = target_m + travel_zero_m_;
  if (raw < p.travel_min_m - kTravelSlack_m || raw > p.travel_max_m + kTravelSlack_m) {
    return Refusal("machine_limits", "travel beyond the machine's own limits");
  }
  return std::nullopt;
}

Verdict SimMachine::check_force_target(MonoTime, double force_N) const {
  if (!limits_) return Refusal("not_armed", "send LIMITS first");
  if (is_moving()) return Refusal("busy", "a motion is going on");
  if (force_N < limits_->force_min.si() || force_N > limits_->force_max.si()) {
    return Refusal("limits", "force beyond LIMITS");
  }
  return std::nullopt;
}

// A motion may lead away from an exceeded force limit, never deeper.
Verdict SimMachine::check_direction(MonoTime t, double direction) const {
  const double force = scene_.force_N(t);
  if (direction > 0 && force > raw_force(t, limits_->force_max.si())) {
    return Refusal("limits", "the force is beyond force_max: move away first");
  }
  if (direction < 0 && force < raw_force(t, limits_->force_min.si())) {
    return Refusal("limits", "the force is below force_min: move closer first");
  }
  return std::nullopt;
}

void SimMachine::begin(MonoTime t, std::int64_t number, double direction) {
  phase_ = Phase::moving;
  put_off_ = false;
  number_ = number;
  direction_ = direction;
  text_.clear();
  arrival_reason_ = MotionEnd::target;
  event_ = std::max(t, scene_.arrival().value_or(t));
  cause_ = Cause::arrived;
}

void SimMachine::consider(std::optional<MonoTime> at, Cause cause) {
  if (!at || *at > event_ || (*at == event_ && cause_ != Cause::arrived)) return;
  event_ = *at;
  cause_ = cause;
}

// The zero of the cell drifts while the motion goes on.
std::optional<MonoTime> SimMachine::crossing(MonoTime t, double shown_N) const {
  auto at = scene_.force_crossing(raw_force(t, shown_N), t, event_);
  if (at && scene_.config().force_drift_N_s != 0) {
    const auto later = scene_.force_crossing(raw_force(*at, shown_N), t, event_);
    if (later) at = later;
  }
  if (!at || settings_.watch_period_s <= 0) return at;
  const double looks = std::ceil(to_seconds(at->time_since_epoch()) / settings_.watch_period_s);
  return std::max(*at, MonoTime(from_seconds(looks * settings_.watch_period_s)));
}

void SimMachine::consider_force_limits(MonoTime t) {
  const double limit = direction_ > 0 ? limits_->force_max.si() : limits_->force_min.si();
  if (raw_force(t, limit) > 0) consider(crossing(t, limit), Cause::force_limit);
}

Verdict SimMachine::move(MonoTime t, std::int64_t number, double travel_m, double speed_m_s) {
  if (auto no = check_motion(travel_m, speed_m_s)) return no;
  if (speed_m_s < 0) return Refusal("bad_value", "MOVE takes a positive speed");
  const double raw = travel_m + travel_zero_m_;
  const double direction = sign(raw - scene_.travel_m(t));
  if (auto no = check_direction(t, direction)) return no;
  force_control_ = false;
  scene_.move_to(t, raw, speed_m_s);
  begin(t, number, direction);
  consider_force_limits(t);
  return std::nullopt;
}

Verdict SimMachine::move_until(MonoTime t, std::int64_t number, double force_N, double speed_m_s,
                               double guard_m) {
  if (auto no = check_force_target(t, force_N)) return no;
  if (auto no = check_motion(guard_m, speed_m_s)) return no;
  const double direction = sign(speed_m_s);
  if (auto no = check_direction(t, direction)) return no;
  const double way = (guard_m + travel_zero_m_ - scene_.travel_m(t)) * direction;
  double goal = force_N;
  // Released means: what the cell shows is no more than the goal, half a digit included.
  if (direction < 0) {
    const double unloaded = offset_N(t) - tare_N_;
    goal = std::max(goal, unloaded + scene_.config().force_resolution_N / 2);
  }
  const bool there = (scene_.force_N(t) - raw_force(t, goal)) * direction >= 0;
  if (way < 0 && !there) return Refusal("bad_value", "the guard lies behind");
  force_control_ = false;
  if (there) {
    scene_.halt(t);
    begin(t, number, direction);
    return std::nullopt;
  }
  scene_.move_to(t, guard_m + travel_zero_m_, std::abs(speed_m_s));
  begin(t, number, direction);
  arrival_reason_ = MotionEnd::travel_limit;
  consider(crossing(t, goal), Cause::goal);
  consider_force_limits(t);  // second, so that a goal at the limit is a goal
  return std::nullopt;
}

double SimMachine::contact_N() const {
  return 5 * std::max(scene_.config().force_resolution_N, scene_.config().force_noise_N);
}

Verdict SimMachine::ramp(MonoTime t, std::int64_t number, double force_N, double rate_N_s) {
  if (!settings_.force_hold) return Refusal("unsupported", "no closed force loop");
  if (auto no = check_force_target(t, force_N)) return no;
  if (!(rate_N_s > 0)) return Refusal("bad_value", "the rate must be positive");
  const double goal = std::max(0.0, raw_force(t, force_N));
  const double direction = sign(goal - scene_.force_N(t));
  if (auto no = check_direction(t, direction)) return no;
  if (raw_force(t, force_N) < -contact_N()) return Refusal("no_contact", "cannot pull");
  begin(t, number, direction);
  if (scene_.force_N(t) <= 0 && goal > 0) {
    begin_approach(t, goal, rate_N_s);
  } else {
    begin_ramp(t, goal, rate_N_s);
  }
  return std::nullopt;
}

// Force control without contact first drives, slowly, until something is felt.
void SimMachine::begin_approach(MonoTime t, double force_N, double rate_N_s) {
  const PlantConfig& p = scene_.config();
  const double speed = std::min({settings_.approach_m_s, limits_->speed_max.si(), p.speed_max_m_s});
  ramp_target_N_ = force_N;
  ramp_rate_N_s_ = rate_N_s;
  force_control_ = false;
  const double end = std::min(limits_->travel_max.si() + travel_zero_m_, p.travel_max_m);
  scene_.move_to(t, end, speed);
  event_ = std::max(t, scene_.arrival().value_or(t));
  arrival_reason_ = MotionEnd::travel_limit;
  const double felt = std::min(contact_N(), force_N / 2);
  consider(crossing(t, felt + offset_N(t) - tare_N_), Cause::contact);
}

// What felt the contact stops first, then the loop closes.
void SimMachine::land(MonoTime t) {
  if (!settings_.loop_lands) return begin_ramp(t, ramp_target_N_, ramp_rate_N_s_);
  scene_.halt(t);
  phase_ = Phase::landing;
  event_ = std::max(t, scene_.arrival().value_or(t));
}

// A loop with a lag goes beyond its target first.
void SimMachine::begin_ramp(MonoTime t, double force_N, double rate_N_s) {
  phase_ = Phase::moving;
  const double rate = std::min(rate_N_s, settings_.loop_rate_max_N_s);
  ramp_target_N_ = held_N(force_N);
  ramp_rate_N_s_ = rate;
  const bool overruns = settings_.loop_lag_s > 0 && force_N > scene_.force_N(t);
  const double beyond = overruns ? rate * settings_.loop_lag_s : 0;
  scene_.ramp_force(t, ramp_target_N_ + beyond, rate);
  force_control_ = true;
  arrival_reason_ = MotionEnd::target;
  event_ = std::max(t, scene_.arrival().value_or(t));
  cause_ = overruns ? Cause::overrun : Cause::arrived;
  const double limit = limits_->force_max.si();
  if (overruns && ramp_target_N_ + beyond > raw_force(t, limit)) {
    cause_ = Cause::arrived;
    consider(crossing(t, limit), Cause::force_limit);
  }
  const double edge = direction_ > 0 ? limits_->travel_max.si() : limits_->travel_min.si();
  const double at_edge = scene_.force_at_travel_N(edge + travel_zero_m_);
  if (at_edge > 0) consider(scene_.force_crossing(at_edge, t, event_), Cause::travel_limit);
}

// Back from beyond the target.
void SimMachine::settle(MonoTime t) {
  scene_.ramp_force(t, ramp_target_N_, ramp_rate_N_s_);
  event_ = std::max(t, scene_.arrival().value_or(t));
  cause_ = Cause::arrived;
}

// Where within the ripple the loop comes to rest.
double SimMachine::held_N(double goal_N) {
  if (settings_.loop_ripple_N <= 0 || goal_N <= 0) return goal_N;
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  return std::max(0.0, goal_N + settings_.loop_ripple_N * part(random_));
}

Verdict SimMachine::hold_force(MonoTime t, double force_N) {
  if (!settings_.force_hold) return Refusal("unsupported", "no closed force loop");
  if (auto no = check_force_target(t, force_N)) return no;
  if (scene_.force_N(t) <= 0) return Refusal("no_contact", "nothing to hold");
  const double goal = held_N(std::max(0.0, raw_force(t, force_N)));
  const double rate = std::clamp(std::abs(goal - scene_.force_N(t)) / kHoldTime_s, kMinRate_N_s,
                                 settings_.loop_rate_max_N_s);
  scene_.ramp_force(t, goal, rate);
  force_control_ = true;
  return std::nullopt;
}

Verdict SimMachine::zero(MonoTime t, bool force, bool travel) {
  if (is_moving()) return Refusal("busy", "zero only while standing");
  // The cell averages over some twenty conversions.
  const PlantConfig& p = scene_.config();
  if (force) {
    const double shown = p.force_gain * scene_.force_N(t) + offset_N(t);
    tare_N_ = shown + gauss(p.force_noise_N / std::sqrt(20.0));
  }
  if (travel) travel_zero_m_ = quantise(scene_.travel_m(t), p.travel_resolution_m);
  ++origin_;
  return std::nullopt;
}

void SimMachine::halt(MonoTime t, MotionEnd reason, std::string text) {
  if (phase_ == Phase::standing && !force_control_) return;
  if (phase_ == Phase::braking) return;  // what began to brake says why
  if (phase_ == Phase::landing) {  // it brakes already
    phase_ = Phase::braking;
    reason_ = reason;
    text_ = std::move(text);
    return;
  }
  text_ = std::move(text);
  brake(t, reason);
}

void SimMachine::brake(MonoTime t, MotionEnd reason) {
  scene_.halt(t);
  force_control_ = false;
  phase_ = Phase::braking;
  reason_ = reason;
  event_ = std::max(t, scene_.arrival().value_or(t));
}

void SimMachine::feel(MonoTime t, const FrameSample& shown) {
  if (phase_ != Phase::moving || !limits_) return;
  const bool beyond = !shown.force_N || *shown.force_N > limits_->force_max.si() ||
                      *shown.force_N < limits_->force_min.si();
  if (beyond) brake(t, MotionEnd::force_limit);
}

void SimMachine::forget() {
  tare_N_ = travel_zero_m_ = 0;
  ++origin_;
  limits_.reset();
}

void SimMachine::stall(MonoTime t) {
  if (phase_ != Phase::moving) return;
  scene_.halt(t);
  phase_ = Phase::hung;
}

std::optional<MonoTime> SimMachine::next_event() const {
  const bool nothing = phase_ == Phase::standing || phase_ == Phase::hung;
  return nothing ? std::nullopt : std::optional(event_);
}

void SimMachine::advance() {
  const MonoTime t = event_;
  if (phase_ == Phase::braking) return finish(t, reason_);
  if (phase_ == Phase::landing) return begin_ramp(t, ramp_target_N_, ramp_rate_N_s_);
  const bool by_force = cause_ == Cause::goal || cause_ == Cause::force_limit;
  if (by_force && late_stop_s_ > 0 && !std::exchange(put_off_, true)) {
    event_ = std::min(t + from_seconds(late_stop_s_), scene_.arrival().value_or(t));
    return;
  }
  switch (cause_) {
    case Cause::arrived: return finish(t, arrival_reason_);
    case Cause::goal: return brake(t, MotionEnd::target);
    case Cause::force_limit: return brake(t, MotionEnd::force_limit);
    case Cause::travel_limit: return brake(t, MotionEnd::travel_limit);
    case Cause::contact: return land(t);
    case Cause::overrun: return settle(t);
  }
}

void SimMachine::finish(MonoTime t, MotionEnd reason) {
  const bool cut = phase_ == Phase::braking && reason_ != MotionEnd::target;
  if (never_complete_ && !cut) {
    phase_ = Phase::hung;
    return;
  }
  phase_ = Phase::standing;
  const FrameSample now = sample(t);
  finished_.emplace();
  finished_->number = std::exchange(number_, std::nullopt);
  finished_->outcome.reason = reason;
  finished_->outcome.detail = std::exchange(text_, {});
  finished_->outcome.force_N = now.force_N;
  finished_->outcome.travel_m = now.travel_m;
}

double SimMachine::offset_N(MonoTime t) const {
  const PlantConfig& p = scene_.config();
  return p.force_offset_N + p.force_drift_N_s * to_seconds(t.time_since_epoch());
}

// The true force at which the samples show this one.
double SimMachine::raw_force(MonoTime t, double shown_N) const {
  return (shown_N + tare_N_ - offset_N(t)) / scene_.config().force_gain;
}

double SimMachine::gauss(double sigma) {
  return sigma > 0 ? sigma * normal_(random_) : 0.0;
}

FrameSample SimMachine::sample(MonoTime t, double spike_N) {
  const PlantConfig& p = scene_.config();
  FrameSample s;
  s.travel_m = quantise(scene_.travel_m(t) - travel_zero_m_, p.travel_resolution_m);
  const double cell =
      p.force_gain * scene_.force_N(t) + offset_N(t) + spike_N + gauss(p.force_noise_N);
  if (std::abs(cell) <= p.force_nominal_N) {
    s.force_N = quantise(cell - tare_N_, p.force_resolution_N);
  } else {
    s.flags |= frame_flag::kForceOverload;
  }
  if (is_moving()) s.flags |= frame_flag::kMoving;
  if (force_control_) s.flags |= frame_flag::kForceControl;
  return s;
}

}  // namespace lcrig::frame_link
