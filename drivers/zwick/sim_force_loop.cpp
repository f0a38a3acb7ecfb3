// SPDX-License-Identifier: Apache-2.0
// Force control of the simulated machine: approach, ramp, hold, and the loop's behaviour with a
// cell that lies.
#include <algorithm>
#include <cmath>

#include "drivers/zwick/sim_machine.hpp"

namespace lcrig::frame_link {

namespace {

constexpr double kHoldTime_s = 0.1;  // a force hold reaches its force in this time
constexpr double kMinRate_N_s = 1e-3;

}  // namespace

Verdict SimMachine::ramp(MonoTime t, std::int64_t number, double force_N, double rate_N_s) {
  if (!settings_.force_hold) return Refusal("unsupported", "no closed force loop");
  if (auto no = check_force_target(force_N)) return no;
  if (!(rate_N_s > 0)) return Refusal("bad_value", "the rate must be positive");
  const double goal = std::max(0.0, cell_.raw_N(t, force_N));
  const double direction = direction_of(goal - scene_.force_N(t));
  if (auto no = check_direction(t, direction)) return no;
  const bool pulls = cell_.is_honest() && cell_.raw_N(t, force_N) < -felt_N(scene_.config());
  if (pulls) return Refusal("no_contact", "cannot pull");
  begin(t, number, direction);
  ramp_shown_N_ = force_N;
  if (scene_.force_N(t) <= 0 && (goal > 0 || !cell_.is_honest())) {
    begin_approach(t, goal, rate_N_s);
  } else {
    begin_ramp(t, goal, rate_N_s);
  }
  return std::nullopt;
}

// Without contact, force control first approaches slowly until the cell shows contact.
void SimMachine::begin_approach(MonoTime t, double force_N, double rate_N_s) {
  const PlantConfig& p = scene_.config();
  const double speed =
      std::min({settings_.approach_m_s, limits_.now().speed_max.si(), p.speed_max_m_s});
  ramp_target_N_ = force_N;
  ramp_rate_N_s_ = rate_N_s;
  force_control_ = false;
  const double end = std::min(limits_.now().travel_max.si() + travel_zero_m_, p.travel_max_m);
  scene_.move_to(t, end, speed);
  arrival_reason_ = MotionEnd::travel_limit;
  goal_N_ = std::min(felt_N(scene_.config()), force_N / 2) + cell_.unloaded_N(t);
  goal_cause_ = Cause::contact;
  look_ahead(t);
}

// At contact: if the loop lands, the drive stops first and then the loop closes.
void SimMachine::land(MonoTime t) {
  if (!settings_.loop_lands) return begin_ramp(t, ramp_target_N_, ramp_rate_N_s_);
  scene_.halt(t);
  phase_ = Phase::landing;
  await_arrival(t);
}

// A loop with a lag first overshoots its target.
void SimMachine::begin_ramp(MonoTime t, double force_N, double rate_N_s) {
  phase_ = Phase::moving;
  goal_N_.reset();
  const double rate = std::min(rate_N_s, settings_.loop_rate_max_N_s);
  ramp_target_N_ = held_N(force_N);
  ramp_rate_N_s_ = rate;
  if (!cell_.is_honest()) {
    force_control_ = true;
    return control(t);
  }
  const bool overruns = settings_.loop_lag_s > 0 && force_N > scene_.force_N(t);
  const double beyond = overruns ? rate * settings_.loop_lag_s : 0;
  scene_.ramp_force(t, ramp_target_N_ + beyond, rate);
  force_control_ = true;
  arrival_reason_ = MotionEnd::target;
  await_arrival(t);
  if (overruns) cause_ = Cause::overrun;
  const double limit = limits_.now().force_max.si();
  if (overruns && ramp_target_N_ + beyond > cell_.raw_N(t, limit)) {
    cause_ = Cause::arrived;
    consider(crossing(t, limit), Cause::force_limit);
  }
  consider_edge(t);
}

void SimMachine::consider_edge(MonoTime t) {
  const double edge =
      direction_ > 0 ? limits_.now().travel_max.si() : limits_.now().travel_min.si();
  const double at_edge = scene_.force_at_travel_N(edge + travel_zero_m_);
  if (at_edge > 0) consider(scene_.force_crossing(at_edge, t, event_), Cause::travel_limit);
}

// The loop believes a cell that lies: it continues at the commanded rate until the cell shows the
// target.
void SimMachine::control(MonoTime t) {
  if (cell_.is_honest() || !limits_.are_set()) {
    if (phase_ == Phase::moving) {
      begin_ramp(t, std::max(0.0, cell_.raw_N(t, ramp_shown_N_)), ramp_rate_N_s_);
    }
    return;
  }
  const double lacks = ramp_shown_N_ - cell_.shown_N(t);
  const double close = felt_N(scene_.config()) + settings_.loop_ripple_N;
  const double follows = cell_.drift_N_s();
  if (std::abs(lacks) <= close && (cell_.is_frozen() || follows == 0)) {
    if (phase_ == Phase::moving) await_arrival(t);
    return;
  }
  const bool is_there = std::abs(lacks) <= close;
  direction_ = is_there ? -direction_of(follows) : direction_of(lacks);
  const double edge =
      direction_ > 0 ? limits_.now().travel_max.si() : limits_.now().travel_min.si();
  const double rate = is_there ? std::abs(follows) : ramp_rate_N_s_;
  scene_.ramp_force(t, scene_.force_at_travel_N(edge + travel_zero_m_), rate);
  if (is_there && phase_ == Phase::standing) return;  // the loop believes that it holds
  phase_ = Phase::moving;
  await_arrival(t);
  arrival_reason_ = MotionEnd::travel_limit;
  if (!cell_.is_frozen() && !is_there) consider(crossing(t, ramp_shown_N_), Cause::felt);
  consider_force_limits(t);
}

// The cell shows the target, so the loop holds the present force.
void SimMachine::settle_as_felt(MonoTime t) {
  scene_.ramp_force(t, scene_.force_N(t), ramp_rate_N_s_);
  finish(t, MotionEnd::target);
  if (cell_.drift_N_s() != 0) control(t);
}

// Returns from the overshoot to the target.
void SimMachine::settle(MonoTime t) {
  scene_.ramp_force(t, ramp_target_N_, ramp_rate_N_s_);
  await_arrival(t);
}

// The force, within the ripple, at which the loop comes to rest.
double SimMachine::held_N(double goal_N) {
  if (settings_.loop_ripple_N <= 0 || goal_N <= 0) return goal_N;
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  return std::max(0.0, goal_N + settings_.loop_ripple_N * part(random_));
}

Verdict SimMachine::hold_force(MonoTime t, double force_N) {
  if (!settings_.force_hold) return Refusal("unsupported", "no closed force loop");
  if (auto no = check_force_target(force_N)) return no;
  if (scene_.force_N(t) <= 0) return Refusal("no_contact", "nothing to hold");
  const double goal = held_N(std::max(0.0, cell_.raw_N(t, force_N)));
  const double rate = std::clamp(std::abs(goal - scene_.force_N(t)) / kHoldTime_s, kMinRate_N_s,
                                 settings_.loop_rate_max_N_s);
  force_control_ = true;
  ramp_shown_N_ = force_N;
  ramp_rate_N_s_ = rate;
  if (cell_.is_honest()) {
    scene_.ramp_force(t, goal, rate);
  } else {
    control(t);
  }
  return std::nullopt;
}

}  // namespace lcrig::frame_link
