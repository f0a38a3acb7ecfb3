// SPDX-License-Identifier: Apache-2.0
// Plans one motion: where it ends, how long it takes, and whether its effect on the specimen is
// allowed. Used by the steps that move the frame.
#pragma once

#include <optional>
#include <string>

#include "protocols/plan/planned_rig.hpp"

namespace lcrig {

// Time to measure the stiffness at contact, at standstill, s.
inline constexpr double kSearchStop_s = 4;

class PlannedMotion {
 public:
  // `timeout` is the step's. Refusals go to `out`.
  PlannedMotion(PlannedRig& rig, const Number& timeout, StepPlan& out)
      : rig_(rig), timeout_(timeout), out_(out) {}

  // Each adds its time to `out.seconds`, because a step may have several motions.
  void to_travel(const Target& to, const Number& speed);
  void to_force(const Target& to, const Number& speed);
  void search(double way_m) { way_m_ = way_m; }
  // Checks assume this speed from now on, whatever the step states. Advice still names the step's.
  void slow_to(double speed_m_s) { slowed_m_s_ = speed_m_s; }
  // Checks a motion that the device stops when the specimen feels `felt_N`. `allowed` is the
  // overshoot that the step allows. `target` is the step's force, if a smaller one would help.
  void check_stop(double felt_N, const Number& speed, const std::optional<Number>& allowed,
                  const Number* target = nullptr);
  void check_timeout();

 private:
  void check_expected(double force_N, const Number& speed, const std::optional<Number>& allowed);
  void check_pressing(double depth_m, const Target& to, const Number& speed);
  void check_blind(const Number& speed);
  void warn_of_the_face(double gap_m, double speed_m_s);
  Refusal too_fast(const std::string& why, const Number& speed, double fastest_m_s,
                   bool may_take_longer);
  // The refusal when every speed is too fast for this force. It names the largest force at which
  // this speed stops in time.
  Refusal too_strong(const std::string& why, double felt_N, const Number& speed,
                     const Number& target);
  double speed_of(const Number& speed) const { return slowed_m_s_.value_or(rig_.get(speed)); }

  PlannedRig& rig_;
  const Number& timeout_;
  StepPlan& out_;
  double way_m_ = 0;
  std::optional<double> slowed_m_s_;
};

// Refuses a force at which the frame's force loop cannot control the contact.
void check_force_loop(double force_N, const PlannedRig& rig, StepPlan& out);

}  // namespace lcrig
