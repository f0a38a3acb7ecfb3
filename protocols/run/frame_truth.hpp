// SPDX-License-Identifier: Apache-2.0
// Knows the unloaded load cell, and judges by each sample whether the frame can be believed, while
// it moves and while it stands. It only judges; `Distrust` acts. Pure logic, told only through
// FrameWatch.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>

#include "drivers/load_frame.hpp"
#include "protocols/plan/limits.hpp"
#include "protocols/watch/guard.hpp"
#include "protocols/watch/plausibility.hpp"
#include "protocols/watch/pressing.hpp"
#include "protocols/watch/rest.hpp"

namespace lcrig {

// What the watch knows of the rig before the run.
struct WatchedRig {
  bool commands = true;  // false: the frame is only observed
  BoundLimits limits;  // of the protocol
  double rate_Hz = 0;  // of the samples
  ForceClass cell = kAssumedForceClass;
  FrameCapabilities frame;
};

// The force as it is shown at the beginning of a motion.
struct ShownForce {
  std::optional<double> last_N;  // the last known one
  bool is_present = false;  // it is the present one
  double wavers_N = 0;  // scatter in the last measurement at rest
};

class FrameTruth {
 public:
  using TellFigures = std::function<void(const WatchFigures&)>;
  // A frame that this run does not move is always believed. `pressing`: nullptr for a frame that
  // cannot move. `tell` is called with new tolerances.
  FrameTruth(const WatchedRig& rig, const Guard& guard, Pressing* pressing, TellFigures tell);

  // The unloaded cell.
  enum class Under { nothing, perhaps_contact };  // what the probe touches
  void learn_rest(const Rest& rest, Under under = Under::nothing);
  // Call after learn_rest of a look near a specimen that was touched. `force_N` is that of a look
  // when nothing had been touched.
  void learn_unpulled(double force_N) { unpulled_N_ = force_N; }
  // Call when the force was zeroed while the probe pressed. `taken_N` is the force that it removed.
  void learn_zero_under_load(double taken_N) { moved_zero_N_ += taken_N; }
  void learn_scatter(const Rest& rest);  // also for a cell that may be loaded
  const std::optional<Rest>& rest() const { return rest_; }  // follows the drift of the cell
  double rest_N() const { return rest_ ? rest_->force_N() : 0; }
  double noise_N() const { return rest_ ? rest_->scatter_N() : 0; }
  // The same for what is compared with every sample: of all looks, and never too small by chance.
  double sure_noise_N() const { return std::max(noise_N(), scatter_.sure_noise_N()); }
  // The force that the cell shows when certainly nothing presses.
  double bare_N() const { return (bare_ ? bare_->force_N() : 0) - moved_zero_N_; }
  // The same, at most: a specimen that sticks may have pulled at the probe when it was measured.
  double most_bare_N() const {
    return unpulled_N_ ? std::max(bare_N(), *unpulled_N_ - moved_zero_N_) : bare_N();
  }
  // True until the cell's digits were seen to change. No motion may press before that.
  bool needs_look() const { return plausible_ && !scatter_.alive; }
  void see_alive(const Rest& rest) { scatter_ = ForceScatter(rest); }
  bool is_loaded(double force_N) const;  // whether the force is more than an unloaded cell shows
  bool is_pulled(double force_N) const;  // whether it is less, whatever the cell's zero does
  double zero_doubt_N() const;  // how far the cell's zero may drift

  // Orders to the frame. `motion_now`: one that begins now, with its tolerances.
  Plausibility::Motion motion_now(double direction, double speed_m_s,
                                  const ShownForce& shown) const;
  // A hold of a force, by the frame's loop.
  Plausibility::Motion hold_now(const ShownForce& shown) const;
  void begin(const Plausibility::Motion& motion, MonoTime now);
  void stand(MonoTime now, std::optional<double> travel_m = std::nullopt);
  void look_away() {
    if (plausible_) plausible_->look_away();
  }
  void zero_force(MonoTime now) {
    if (plausible_) plausible_->zero_force(now);
  }
  void distrust_force() {
    if (plausible_) plausible_->distrust_force();
  }

  // What the travel of a standing frame may differ by, from sample to sample.
  double still_m() const;

  // Samples of the frame.
  std::optional<Contradiction> check(const FrameSample& sample);
  // Judges a force below the lower limit. nullopt: the specimen may be pulling at the probe.
  std::optional<Contradiction> check_fall(const FrameSample& sample) const;
  // The tolerances; nullptr: this frame is always believed.
  const WatchFigures* figures() const { return plausible_ ? &plausible_->figures() : nullptr; }

  // The contact, once its stiffness was measured.
  void know_contact(MonoTime now, double travel_m, double felt_N, double stiffness_N_m);
  void forget_contact() {
    if (plausible_) plausible_->press().forget();
  }
  void zero_travel(double travel_m);  // this travel becomes 0, and the contact unknown
  bool knows_contact() const { return plausible_ && plausible_->press().knows(); }
  // The travel by which a motion to this force must stop, if it is known.
  std::optional<double> furthest_m(MonoTime now, double force_N) const;

 private:
  double load_doubt_N() const;

  const WatchedRig& rig_;
  const Guard& guard_;
  Pressing* pressing_;
  TellFigures tell_;
  std::optional<Plausibility> plausible_;
  ForceScatter scatter_;  // everything seen of the unloaded cell
  double drift_N_s_ = 0;  // known drift of the cell, a magnitude
  std::optional<Rest> rest_, bare_;
  double moved_zero_N_ = 0;  // taken out by zeros since bare_ was measured
  std::optional<double> unpulled_N_;
};

}  // namespace lcrig
