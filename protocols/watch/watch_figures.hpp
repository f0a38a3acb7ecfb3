// SPDX-License-Identifier: Apache-2.0
// The tolerances of Plausibility: how long, and by how much, samples must deviate before they
// cannot be true. Derived from the machine, the bound of the contact and the scatter at rest. The
// plan prints them, and the run stores them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "drivers/load_frame.hpp"
#include "protocols/plan/force_bound.hpp"
#include "protocols/watch/rest.hpp"

namespace lcrig {

// The scatter of the force of an unloaded cell, sample by sample.
class ForceScatter {
 public:
  ForceScatter() = default;
  explicit ForceScatter(const Rest& rest);
  // Adds another look at the same cell. A run of equal forces counts as normal only if it is far
  // shorter than `frozen`.
  void add(const Rest& rest, std::optional<std::int64_t> frozen);
  double noise_N = 0;  // standard deviation
  // From all looks together, and at least that of the last one, so much larger that chance does not
  // reach kSampleSigmas of it. Noise below half a digit may show as nothing, so it is never less
  // than that. 0: nothing was seen.
  double sure_noise_N() const;
  // The most that sure_noise_N of another look at the same cell, with as many samples, will be.
  double sure_noise_anew_N() const;
  double digit_N = 0;  // smallest difference of two samples
  std::int64_t longest_run = 1;  // of consecutive equal forces
  bool alive = false;
  // Standard deviation at the first look. Later looks are not used, because the frame may creep
  // then.
  std::optional<double> travel_noise_m;

 private:
  double squares_N2_ = 0, freedoms_ = 0;  // of all looks
  double last_N_ = 0;
};

// A search that stops at fewer standard deviations of the cell would stop at noise.
constexpr double kContactSigmas = kNoiseSigmas;

struct WatchFigures {
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
  double coarsest_digit_m = kCoarsestDigit_m;  // of a travel whose digit was not seen yet
  double settled_s = 0;  // after a motion, while its samples may still arrive
  double reply_s = 0;  // from the arrival of a contradicting sample to the sending of STOP
};

// `scatter`: absent before the first look (then a digit of a third of the scatter is assumed).
// `limit_N`: of the force. `noise_N`: standard deviation of a sample.
WatchFigures watch_figures(const FrameCapabilities& caps, const ForceBound& bound, double limit_N,
                           double rate_Hz, const std::optional<ForceScatter>& scatter,
                           double noise_N);

nlohmann::json to_json(const WatchFigures& figures);

}  // namespace lcrig
