// SPDX-License-Identifier: Apache-2.0
// The simulated machine: limits, motion with device-side stops, tare, noise. Used by the simulated
// gateway (sim.hpp).
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <string>

#include "drivers/load_frame.hpp"
#include "drivers/zwick/sim.hpp"
#include "drivers/zwick/sim_cell.hpp"
#include "drivers/zwick/sim_drive.hpp"
#include "drivers/zwick/sim_limits.hpp"

namespace lcrig::frame_link {

// A motion that ended. Without a number, no client waits for its end.
struct FinishedMotion {
  std::optional<std::int64_t> number;
  MotionOutcome outcome;
};

// Values are tared, as samples show them, unless a name says raw. Times must not go backwards: the
// owner handles every next_event() before it commands anything at a later time.
class SimMachine {
 public:
  SimMachine(FrameScene& scene, const ZwickSimSettings& settings);

  FrameCapabilities capabilities() const { return limits_.of_machine(); }
  // Changes whenever a zero was lost or changed.
  std::string origin() const { return std::to_string(origin_); }
  Verdict set_limits(const FrameLimits& limits);
  void disarm() { limits_.forget(); }
  void forget_command() { number_.reset(); }  // the end of its motion is not reported
  bool is_armed() const { return limits_.are_set(); }

  Verdict move(MonoTime t, std::int64_t number, double travel_m, double speed_m_s);
  Verdict move_until(MonoTime t, std::int64_t number, double force_N, double speed_m_s,
                     double guard_m);
  Verdict ramp(MonoTime t, std::int64_t number, double force_N, double rate_N_s);
  Verdict hold_force(MonoTime t, double force_N);
  Verdict zero(MonoTime t, bool force, bool travel);
  // Brakes and leaves force control. The interrupted motion ends with `reason`.
  void halt(MonoTime t, MotionEnd reason, std::string text);
  void stall(MonoTime t);
  void set_lies(MonoTime t, const ZwickSimLies& lies);
  void drop_number() { number_.reset(); }  // the end of this motion is not reported
  // Like drop_number, and the gateway also accepts the next motion.
  void disown() { disowned_ = number_.has_value(), number_.reset(); }
  void lose_tare(bool says_so);
  void set_never_complete(bool on) { never_complete_ = on; }
  void set_late_stop(double seconds) { late_stop_s_ = seconds; }
  // Ends a motion when a sample exceeds the limits, even without a true force behind it.
  void feel(MonoTime t, const FrameSample& shown);
  void forget();  // as after switching off: loses tare, zero and limits

  double travel_zero_m() const { return travel_zero_m_; }
  bool is_moving() const { return phase_ != Phase::standing && !disowned_; }
  std::optional<MonoTime> next_event() const;
  // Handles the event that is due.
  void advance();
  std::optional<FinishedMotion> take_finished() { return std::exchange(finished_, std::nullopt); }

  // Leaves number and device time unset. `spike_N` acts on the cell, not on the specimen.
  FrameSample sample(MonoTime t, double spike_N = 0);

 private:
  enum class Phase { standing, moving, braking, landing, hung };
  enum class Cause { arrived, goal, force_limit, travel_limit, contact, overrun, felt };

  Verdict check_ready() const;
  Verdict check_motion(double target_m, double speed_m_s) const;
  Verdict check_force_target(double force_N) const;
  Verdict check_direction(MonoTime t, double direction) const;
  void begin(MonoTime t, std::int64_t number, double direction);
  void begin_approach(MonoTime t, double force_N, double rate_N_s);
  void begin_ramp(MonoTime t, double force_N, double rate_N_s);
  void control(MonoTime t);
  void cut(MonoTime t);
  void await_arrival(MonoTime t);
  void look_ahead(MonoTime t);
  void consider(std::optional<MonoTime> at, Cause cause);
  // When the device notices that a motion from `t` on passes `shown_N`.
  std::optional<MonoTime> crossing(MonoTime t, double shown_N) const;
  void consider_force_limits(MonoTime t);
  void consider_edge(MonoTime t);
  void land(MonoTime t);
  void settle(MonoTime t);
  void settle_as_felt(MonoTime t);
  void finish(MonoTime t, MotionEnd reason);
  void brake(MonoTime t, MotionEnd reason);
  double held_N(double goal_N);

  SimDrive drive_;
  FrameScene& scene_;  // the scene through drive_, which may disobey
  const ZwickSimSettings& settings_;
  SimLimits limits_;
  std::mt19937_64 random_;
  SimCell cell_;
  ZwickSimLies lies_;

  double travel_zero_m_ = 0;
  std::int64_t origin_ = 1;

  Phase phase_ = Phase::standing;
  bool force_control_ = false;
  bool never_complete_ = false;
  double late_stop_s_ = 0;
  bool put_off_ = false;  // the stop of this motion was already delayed
  bool disowned_ = false;
  std::optional<double> goal_N_;  // for a motion that stops at a force, as shown
  Cause goal_cause_ = Cause::goal;
  std::optional<std::int64_t> number_;
  double direction_ = 0;  // +1 towards the specimen
  MonoTime event_;
  Cause cause_ = Cause::arrived;
  MotionEnd arrival_reason_ = MotionEnd::target;  // for a drive that arrives by itself
  MotionEnd reason_ = MotionEnd::target;  // for the end of braking
  std::string text_;
  double ramp_target_N_ = 0, ramp_rate_N_s_ = 0;  // raw
  double ramp_shown_N_ = 0;  // the target as shown
  std::optional<FinishedMotion> finished_;
};

}  // namespace lcrig::frame_link
