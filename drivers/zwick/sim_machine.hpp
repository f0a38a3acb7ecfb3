// SPDX-License-Identifier: Apache-2.0
// The machine behind the simulated gateway: limits, motion with device-side stops, tare, noise.
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <string>

#include "drivers/load_frame.hpp"
#include "drivers/zwick/sim.hpp"

namespace lcrig::frame_link {

struct Refusal {
  Refusal(std::string c, std::string t) : code(std::move(c)), text(std::move(t)) {}
  std::string code, text;  // as in ERR
};
using Verdict = std::optional<Refusal>;  // nullopt: accepted

// A motion that ended. Without a number nobody asked to be told.
struct FinishedMotion {
  FinishedMotion() = default;
  std::optional<std::int64_t> number;
  MotionOutcome outcome;
};

// Values are as the samples show them (tared) unless a name says raw. Times never run backwards;
// the owner handles every next_event() before it commands anything later.
class SimMachine {
 public:
  SimMachine(FrameScene& scene, const ZwickSimSettings& settings);

  FrameCapabilities capabilities() const;
  // A new one whenever a zero was lost or changed.
  std::string origin() const { return std::to_string(origin_); }
  Verdict set_limits(MonoTime t, const FrameLimits& limits);
  void disarm() { limits_.reset(); }
  void forget_command() { number_.reset(); }  // nobody is told when its motion ends
  bool is_armed() const { return limits_.has_value(); }

  Verdict move(MonoTime t, std::int64_t number, double travel_m, double speed_m_s);
  Verdict move_until(MonoTime t, std::int64_t number, double force_N, double speed_m_s,
                     double guard_m);
  Verdict ramp(MonoTime t, std::int64_t number, double force_N, double rate_N_s);
  Verdict hold_force(MonoTime t, double force_N);
  Verdict zero(MonoTime t, bool force, bool travel);
  // Brakes; the motion that was cut ends with `reason`. Also leaves force control.
  void halt(MonoTime t, MotionEnd reason, std::string text);
  void stall(MonoTime t);
  void set_never_complete(bool on) { never_complete_ = on; }
  void set_late_stop(double seconds) { late_stop_s_ = seconds; }
  // A sample beyond the limits that no true force explains ends a motion all the same.
  void feel(MonoTime t, const FrameSample& shown);
  void forget();  // as after switching off: tare, zero and limits

  double travel_zero_m() const { return travel_zero_m_; }
  bool is_moving() const { return phase_ != Phase::standing; }
  std::optional<MonoTime> next_event() const;
  // Handles the event that is due.
  void advance();
  std::optional<FinishedMotion> take_finished() { return std::exchange(finished_, std::nullopt); }

  // Without number and device time. `spike_N` is on the cell, not on the specimen.
  FrameSample sample(MonoTime t, double spike_N = 0);

 private:
  enum class Phase { standing, moving, braking, landing, hung };
  enum class Cause { arrived, goal, force_limit, travel_limit, contact, overrun };

  Verdict check_motion(double target_m, double speed_m_s) const;
  Verdict check_force_target(MonoTime t, double force_N) const;
  Verdict check_direction(MonoTime t, double direction) const;
  void begin(MonoTime t, std::int64_t number, double direction);
  void begin_approach(MonoTime t, double force_N, double rate_N_s);
  void begin_ramp(MonoTime t, double force_N, double rate_N_s);
  void consider(std::optional<MonoTime> at, Cause cause);
  // When a motion that began at t is seen to pass what the samples show as this.
  std::optional<MonoTime> crossing(MonoTime t, double shown_N) const;
  void consider_force_limits(MonoTime t);
  void land(MonoTime t);
  void settle(MonoTime t);
  void finish(MonoTime t, MotionEnd reason);
  void brake(MonoTime t, MotionEnd reason);
  double offset_N(MonoTime t) const;  // of the cell
  double raw_force(MonoTime t, double shown_N) const;
  double held_N(double goal_N);
  double gauss(double sigma);
  double contact_N() const;

  FrameScene& scene_;
  const ZwickSimSettings& settings_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;

  std::optional<FrameLimits> limits_;
  double tare_N_ = 0;
  double travel_zero_m_ = 0;
  std::int64_t origin_ = 1;

  Phase phase_ = Phase::standing;
  bool force_control_ = false;
  bool never_complete_ = false;
  double late_stop_s_ = 0;
  bool put_off_ = false;  // the stop of this motion was put off once
  std::optional<std::int64_t> number_;
  double direction_ = 0;  // +1 towards the specimen
  MonoTime event_;
  Cause cause_ = Cause::arrived;
  MotionEnd arrival_reason_ = MotionEnd::target;  // when the drive arrives by itself
  MotionEnd reason_ = MotionEnd::target;  // after braking
  std::string text_;
  double ramp_target_N_ = 0, ramp_rate_N_s_ = 0;  // raw, while approaching
  std::optional<FinishedMotion> finished_;
};

}  // namespace lcrig::frame_link
