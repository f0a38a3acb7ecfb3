// SPDX-License-Identifier: Apache-2.0
// The tolerances of the checks: how long, and by how much, samples must deviate before they
// cannot be true. Derived from the machine, the bound of the contact and the scatter at rest. The
// plan prints them, and the run stores them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "drivers/load_frame.hpp"
#include "protocols/rig/force_bound.hpp"

namespace lcrig {

class CellNoise;

struct Tolerances {
  // A frozen cell shows at least this many equal forces in a row, for this time. Absent: the digits
  // of the cell are coarser than its scatter, so a healthy cell repeats itself, too.
  std::optional<std::int64_t> frozen_samples;
  std::optional<double> frozen_force_s;
  double stall_s = 0;  // without travel, though commanded; longer at the slowest speeds
  double against_m = 0;  // travel against the order
  double standing_m = 0;  // travel without an order
  double order_travel_m = 0;  // between the target and the reported end
  double order_force_N = 0;  // the same for a force; one hundredth of it is added
  double contact_force_N = 0;  // smallest change of force that is not chance
  double travel_noise_m = 0;  // standard deviation of a sample at rest
  double settled_s = 0;  // after a motion, while its samples may still arrive
  double reply_s = 0;  // from the arrival of a contradicting sample to the sending of STOP
};

// `scatter`: null before the first look (then a digit of a third of the scatter is assumed).
// `limit_N`: of the force. `noise_N`: standard deviation of a sample.
Tolerances tolerances_of(const FrameCapabilities& caps, const ForceBound& bound, double limit_N,
                         double rate_Hz, const CellNoise* scatter, double noise_N);

nlohmann::json to_json(const Tolerances& figures);

}  // namespace lcrig
