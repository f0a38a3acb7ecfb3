// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/sim_machine.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lcrig::frame_link {

SimMachine::SimMachine(FrameScene& scene, const ZwickSimSettings& settings)
    : drive_(scene),
      scene_(drive_),
      settings_(settings),
      limits_(scene, settings),
      random_(settings.seed),
      cell_(drive_, random_) {}

void SimMachine::set_lies(MonoTime t, const ZwickSimLies& lies) {
  if (lies == lies_) return;
  const ZwickSimLies was = std::exchange(lies_, lies);
  cell_.set_lies(t, lies);
  drive_.set_reversed(t, lies.drive_reversed);
  drive_.set_mirrored(t, lies.drive_mirrored);
  if (lies.estop && !was.estop) cut(t);
  if (phase_ == Phase::standing && lies.creep_m_s != was.creep_m_s && !force_control_) {
    drive_.creep(t, lies.creep_m_s);
  }
  if (force_control_ && phase_ != Phase::braking) return control(t);
  if (phase_ == Phase::moving) look_ahead(t);
}

// E-stop: the drive has no power, so whatever it is doing ends.
void SimMachine::cut(MonoTime t) {
  if (phase_ == Phase::standing && !force_control_ && !drive_.is_creeping()) return;
  text_ = "E-stop";
  brake(t, MotionEnd::fault);
}

Verdict SimMachine::set_limits(const FrameLimits& limits) {
  if (is_moving()) return Refusal("busy", "limits change only while standing");
  return limits_.set(limits, travel_zero_m_);
}

Verdict SimMachine::check_ready() const {
  if (lies_.estop) return Refusal("not_ready", "E-stop");
  if (!limits_.are_set()) return Refusal("not_armed", "send LIMITS first");
  if (is_moving()) return Refusal("busy", "a motion is going on");
  return std::nullopt;
}

Verdict SimMachine::check_motion(double target_m, double speed_m_s) const {
  if (auto no = check_ready()) return no;
  return limits_.check_motion(target_m, speed_m_s, travel_zero_m_);
}

Verdict SimMachine::check_force_target(double force_N) const {
  if (auto no = check_ready()) return no;
  return limits_.check_force(force_N);
}

Verdict SimMachine::check_direction(MonoTime t, double direction) const {
  return limits_.check_direction(cell_.shown_N(t), direction);
}

void SimMachine::begin(MonoTime t, std::int64_t number, double direction) {
  phase_ = Phase::moving;
  put_off_ = disowned_ = false;
  goal_N_.reset();
  number_ = number;
  direction_ = direction;
  text_.clear();
  arrival_reason_ = MotionEnd::target;
  await_arrival(t);
}

void SimMachine::await_arrival(MonoTime t) {
  event_ = std::max(t, scene_.arrival().value_or(t));
  cause_ = Cause::arrived;
}

// Finds the event that will end the current motion, judged by what the device can know.
void SimMachine::look_ahead(MonoTime t) {
  await_arrival(t);
  if (goal_N_) consider(crossing(t, *goal_N_), goal_cause_);
  if (goal_N_ && goal_cause_ == Cause::contact && cell_.is_honest()) return;
  consider_force_limits(t);  // after the goal, so that a goal at the limit counts as goal
}

void SimMachine::consider(std::optional<MonoTime> at, Cause cause) {
  if (!at || *at > event_ || (*at == event_ && cause_ != Cause::arrived)) return;
  event_ = *at;
  cause_ = cause;
}

std::optional<MonoTime> SimMachine::crossing(MonoTime t, double shown_N) const {
  const auto at = cell_.crossing(shown_N, t, event_);
  if (!at || settings_.watch_period_s <= 0) return at;
  const double looks = std::ceil(to_seconds(at->time_since_epoch()) / settings_.watch_period_s);
  return std::max(*at, MonoTime(from_seconds(looks * settings_.watch_period_s)));
}

// With an honest cell and drive only the limit ahead can be reached. Otherwise either one can.
void SimMachine::consider_force_limits(MonoTime t) {
  if (!limits_.are_set()) return;
  const double low = limits_.now().force_min.si(), high = limits_.now().force_max.si();
  if (cell_.is_honest() && !drive_.is_backwards()) {
    const double limit = direction_ > 0 ? high : low;
    if (cell_.raw_N(t, limit) > 0) consider(crossing(t, limit), Cause::force_limit);
    return;
  }
  const double shown = cell_.shown_N(t);
  if (shown < low || shown > high) return;
  consider(crossing(t, low), Cause::force_limit);
  consider(crossing(t, high), Cause::force_limit);
}

Verdict SimMachine::move(MonoTime t, std::int64_t number, double travel_m, double speed_m_s) {
  if (auto no = check_motion(travel_m, speed_m_s)) return no;
  if (speed_m_s < 0) return Refusal("bad_value", "MOVE takes a positive speed");
  const double raw = travel_m + travel_zero_m_;
  const double direction = direction_of(raw - scene_.travel_m(t));
  if (auto no = check_direction(t, direction)) return no;
  force_control_ = false;
  scene_.move_to(t, raw, speed_m_s);
  begin(t, number, direction);
  look_ahead(t);
  return std::nullopt;
}

Verdict SimMachine::move_until(MonoTime t, std::int64_t number, double force_N, double speed_m_s,
                               double guard_m) {
  if (auto no = check_force_target(force_N)) return no;
  if (auto no = check_motion(guard_m, speed_m_s)) return no;
  const double direction = direction_of(speed_m_s);
  if (auto no = check_direction(t, direction)) return no;
  const double way = (guard_m + travel_zero_m_ - scene_.travel_m(t)) * direction;
  double goal = force_N;
  // A release ends when the shown force is at most the goal, give or take half a digit.
  if (direction < 0) {
    goal = std::max(goal, cell_.unloaded_N(t) + scene_.config().force_resolution_N / 2);
  }
  const bool there = (cell_.shown_N(t) - goal) * direction >= -kForceSlack_N;
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
  goal_N_ = goal;
  goal_cause_ = Cause::goal;
  look_ahead(t);
  return std::nullopt;
}

Verdict SimMachine::zero(MonoTime t, bool force, bool travel) {
  if (is_moving()) return Refusal("busy", "zero only while standing");
  const PlantConfig& p = scene_.config();
  if (force) cell_.tare(t);
  if (travel) travel_zero_m_ = quantise(scene_.travel_m(t), p.travel_resolution_m);
  ++origin_;
  return std::nullopt;
}

void SimMachine::halt(MonoTime t, MotionEnd reason, std::string text) {
  if (phase_ == Phase::standing && !force_control_ && !drive_.is_creeping()) return;
  if (phase_ == Phase::braking) return;  // the first cause of braking is reported
  if (phase_ == Phase::landing) {  // the drive brakes already
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
  force_control_ = disowned_ = false;
  phase_ = Phase::braking;
  reason_ = reason;
  await_arrival(t);
}

void SimMachine::feel(MonoTime t, const FrameSample& shown) {
  if (phase_ != Phase::moving || !limits_.are_set()) return;
  const bool beyond = !shown.force_N || *shown.force_N > limits_.now().force_max.si() ||
                      *shown.force_N < limits_.now().force_min.si();
  if (beyond) brake(t, MotionEnd::force_limit);
}

void SimMachine::lose_tare(bool says_so) {
  cell_.forget_tare();
  if (says_so) ++origin_;
}

void SimMachine::forget() {
  cell_.forget_tare();
  travel_zero_m_ = 0;
  ++origin_;
  limits_.forget();
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
  if (cause_ == Cause::arrived && drive_.is_astray()) {
    text_ = "the end of the way";
    return finish(t, MotionEnd::fault);
  }
  switch (cause_) {
    case Cause::arrived: return finish(t, arrival_reason_);
    case Cause::felt: return settle_as_felt(t);
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
  disowned_ = false;
  const bool by_itself = reason != MotionEnd::stopped && reason != MotionEnd::fault;
  if (by_itself && !force_control_ && lies_.creep_m_s != 0) drive_.creep(t, lies_.creep_m_s);
  const FrameSample now = sample(t);
  finished_.emplace();
  finished_->number = std::exchange(number_, std::nullopt);
  finished_->outcome.reason = reason;
  finished_->outcome.detail = std::exchange(text_, {});
  finished_->outcome.force_N = now.force_N;
  finished_->outcome.travel_m = now.travel_m;
}

FrameSample SimMachine::sample(MonoTime t, double spike_N) {
  const PlantConfig& p = scene_.config();
  FrameSample s;
  s.travel_m = quantise(scene_.travel_m(t) - travel_zero_m_, p.travel_resolution_m);
  s.force_N = cell_.convert(t, spike_N);
  if (!s.force_N) s.flags |= frame_flag::kForceOverload;
  if (is_moving()) s.flags |= frame_flag::kMoving;
  if (force_control_) s.flags |= frame_flag::kForceControl;
  return s;
}

}  // namespace lcrig::frame_link
