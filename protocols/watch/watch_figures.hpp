// SPDX-License-Identifier: Apache-2.0
// How soon, and how far off, what a frame shows must be before it cannot be true. Derived from the
// machine, the bound of the contact and the scatter at rest: printed by the plan, stored with the
// run, and the only tolerances that Plausibility knows.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "drivers/load_frame.hpp"
#include "protocols/plan/force_bound.hpp"
#include "protocols/watch/rest.hpp"

namespace lcrig {

// How the force of an unloaded cell scatters, sample by sample.
struct ForceScatter {
  ForceScatter() = default;
  explicit ForceScatter(const Rest& rest);
  // Another look at the same cell, which repeats itself less often than `frozen` times.
  void add(const Rest& rest, std::optional<std::int64_t> frozen);
  double noise_N = 0;  // standard deviation
  double digit_N = 0;  // least difference of two samples
  std::int64_t longest_run = 1;  // of equal ones
  bool alive = false;
  // Standard deviation, at the first look: later the frame may creep, and none is learned from.
  std::optional<double> travel_noise_m;
};

// A search that stops at fewer standard deviations of the cell finds its noise.
constexpr double kContactSigmas = kNoiseSigmas;

struct WatchFigures {
  // A frozen cell shows at least this many equal forces in a row, for this time. Absent: the digits
  // of the cell are coarser than its scatter, so a sound one repeats itself, too.
  std::optional<std::int64_t> frozen_samples;
  std::optional<double> frozen_force_s;
  double stall_s = 0;  // no travel for so long, though commanded; longer at the slowest speeds
  double against_m = 0;  // travel against the command
  double standing_m = 0;  // travel where nothing of ours moves
  double order_travel_m = 0;  // between the target and where the frame says that it stands
  double order_force_N = 0;  // the same for a force, and one hundredth of it
  double contact_force_N = 0;  // the least change of force that is no chance
  double travel_noise_m = 0;  // standard deviation of a sample while it stands
  double settled_s = 0;  // after a motion its samples may still be on their way
  double reply_s = 0;  // from the arrival of a sample that contradicts until STOP goes out
};

// `scatter`: absent where nobody has looked yet (a digit of a third of the scatter is assumed).
// `limit_N`: of the force. `noise_N`: standard deviation of a sample.
WatchFigures watch_figures(const FrameCapabilities& caps, const ForceBound& bound, double limit_N,
                           double rate_Hz, const std::optional<ForceScatter>& scatter,
                           double noise_N);

nlohmann::json to_json(const WatchFigures& figures);

}  // namespace lcrig
