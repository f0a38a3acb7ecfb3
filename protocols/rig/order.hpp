// SPDX-License-Identifier: Apache-2.0
// The order to the frame that its samples are compared with, and what was predicted for it.
#pragma once

#include <optional>

#include "drivers/load_frame.hpp"
#include "events/payloads.hpp"

namespace lcrig {

struct Order {
  double direction = 0;  // +1: towards the specimen; -1: away; 0: the force loop decides
  double speed_m_s = 0;  // for the force loop: of its approach
  double rate_N_s = 0;  // for the force loop: rate of its ramp; 0: it holds
  double force_N = 0;  // shown force at the start
  bool force_known = true;  // false: the first force shown counts as that at the start
  double zero_N = 0;  // of the cell
  // The most that the cell shows once a specimen that pulls at the probe has let go.
  std::optional<double> free_N;
  // The largest fall of the force that is allowed while moving towards the specimen, or rise while
  // moving away; and its growth with time, for a cell that is known to drift.
  double against_N = 0, drift_N_s = 0;
  double loop_N = 0;  // by which a force loop varies the force, to either side
  std::optional<double> target_m;  // end of the motion; a servo may overshoot it and come back
  std::optional<double> to_N;  // of a force loop: the end of its ramp, or what it holds
  bool holds = false;  // holds a force until the next order
  // The largest force that was predicted for it; nullopt: it does not press. The cell may show it
  // only some time after the frame stands.
  std::optional<double> worst_N;
};

// Permission for one motion.
struct Permit {
  FrameLimits limits;  // limits that the frame watches during the motion
  Length guard;  // travel at which a search for a force must stop
  std::optional<double> threshold_N;  // force at which the frame has to stop; absent: it does not
                                      // stop at a force
  double worst_N = 0;  // largest force until it stands
  std::optional<double> expected_N;
  bool presses = false;  // it may end in the specimen
  std::optional<double> from_m;  // travel at its start
};

// As stored, and again. What only the frame needs (its limits, the guard) is not stored.
WatchInputEvent to_input(const Order& order);
WatchInputEvent to_input(const Permit& permit);
Order order_of(const WatchInputEvent& input);
Permit permit_of(const WatchInputEvent& input);

}  // namespace lcrig
