// SPDX-License-Identifier: Apache-2.0
// Carries out one motion of the frame: judges whether it may begin, sets the limits that the device
// watches meanwhile, and checks that it ended at its target. Steps move the frame only through it.
#pragma once

#include <optional>

#include "base/result.hpp"
#include "base/task.hpp"
#include "drivers/load_frame.hpp"
#include "protocols/rig/order.hpp"

namespace lcrig {

class EventLog;
class FrameDrive;
class FrameWatch;
class RestMeter;
class RigState;
class TimeSpent;  // steps/progress.hpp
struct ForceComparison;  // rig/prediction.hpp
struct RunSetup;

// The longest time of a motion. With `t`, the earlier motions of the step count, too.
struct TimeLimit {
  TimeLimit(double s, TimeSpent* t = nullptr) : seconds(s), spent(t) {}
  double seconds;
  TimeSpent* spent;
};

// The order of a motion: how it begins, and where it must end.
struct MotionOrder {
  Order motion;
  std::optional<double> travel_m, force_N;  // one of them is the target
  int side = 0;  // for a force target: at least (1), at most (-1), within (0)
  double loop_N = 0;  // of a force loop, to either side
  bool by_contact = false;  // it stops where the contact must have shown the force
  bool either_side = false;  // a fall to the lower force limit is an end, too
};

class Motions {
 public:
  // All must outlive it.
  Motions(const RunSetup& setup, const EventLog& log, FrameWatch& watch, RestMeter& meter,
          FrameDrive& drive);

  // Errors of all: invalid_request (nothing has moved), no_reply (not within the time-out),
  // limit_tripped, aborted, refused (also when the frame is not where it reports to be).
  Task<Result<>> to_travel(double travel_m, double speed_m_s, TimeLimit limit);
  // Moves towards the specimen if the force has to grow, otherwise away from it.
  Task<Result<>> to_force(double force_N, double speed_m_s, TimeLimit limit);
  Task<Result<>> ramp_to_force(double force_N, double rate_N_s, TimeLimit limit);
  // Bounds of a search for a force: it stops at this travel at the latest, and when the force falls
  // to `least_N`.
  struct Search {
    Search(double end, double least) : end_m(end), least_N(least) {}
    double end_m, least_N;
  };
  Task<Result<MotionOutcome>> press_until(double force_N, double speed_m_s, TimeLimit limit,
                                          std::optional<Search> search);

  // The frame has reported `target`. Its samples must agree, the next ones at the latest. Errors:
  // refused.
  Task<Result<>> confirm_end(const MotionOrder& order, const MotionOutcome& outcome) const;
  // Writes the event of a motion that stopped at a force.
  void report(const ForceComparison& seen) const;

  bool in_motion() const { return in_motion_; }
  double last_speed_m_s() const { return last_speed_m_s_; }  // of the last requested motion

 private:
  MotionOrder order_of(double force_N, int side, double speed_m_s) const;
  Task<Result<MotionOutcome>> watched(MotionOrder order, Permit permit,
                                      Task<Result<MotionOutcome>> motion, TimeLimit limit);
  Task<Result<>> ready_for(const Permit& permit);
  Task<Result<MotionOutcome>> timed(const MotionOrder& order, Task<Result<MotionOutcome>> motion,
                                    TimeLimit limit);
  void see_end(const MotionOrder& order, const MotionOutcome& outcome);
  std::string disagreement(const MotionOrder& order, const MotionOutcome& outcome) const;
  tl::unexpected<Error> refused(const Error& error) const;  // names the refused step

  const RunSetup& setup_;
  const EventLog& log_;
  FrameWatch& watch_;
  const RigState& rig_;
  RestMeter& meter_;
  FrameDrive& drive_;
  bool in_motion_ = false;
  double last_speed_m_s_ = 0;
};

}  // namespace lcrig
