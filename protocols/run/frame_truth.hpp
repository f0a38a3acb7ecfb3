// SPDX-License-Identifier: Apache-2.0
// Knows the unloaded load cell, and judges whether the frame can be believed: by each sample while
// it moves and stands, and by where a motion ended. It only judges; `Distrust` acts on it. Motions
// and steps tell it what the frame was ordered to do.
#pragma once

#include <optional>
#include <string>

#include "protocols/run/event_log.hpp"
#include "protocols/run/frame_view.hpp"
#include "protocols/run/setup.hpp"
#include "protocols/watch/guard.hpp"
#include "protocols/watch/plausibility.hpp"
#include "protocols/watch/pressing.hpp"
#include "protocols/watch/rest.hpp"

namespace lcrig {

// Order of a motion: how it begins, and where it has to end.
struct MotionOrder {
  Plausibility::Motion motion;
  std::optional<double> travel_m, force_N;  // one of them
  int side = 0;  // of a force: at least (1), at most (-1), within (0)
  double waver_N = 0;  // of a force loop
  bool either_side = false;  // a force that falls to its lower limit ends it as well
};

class FrameTruth {
 public:
  // A frame that this run does not move is believed whatever it shows. `pressing`: nullptr for a
  // frame that cannot move.
  FrameTruth(const RunSetup& setup, const EventLog& log, const Guard& guard, Pressing* pressing,
             const FrameView& view);

  // The unloaded cell
  enum class Under { nothing, perhaps_contact };  // the probe
  void learn_rest(const Rest& rest, Under under = Under::nothing);
  // The probe pressed while the force was zeroed, which took this much out of it.
  void learn_zero_under_load(double taken_N) { moved_zero_N_ += taken_N; }
  void learn_scatter(const Rest& rest);  // of a cell that may be loaded, too
  const std::optional<Rest>& rest() const { return rest_; }  // as it drifts
  double rest_N() const { return rest_ ? rest_->force_N() : 0; }
  double noise_N() const { return rest_ ? rest_->scatter_N() : 0; }
  // Force that the cell shows when certainly nothing presses.
  double bare_N() const { return (bare_ ? bare_->force_N() : 0) - moved_zero_N_; }
  // True until the digits of the cell were seen to change: no motion may press before that.
  bool needs_look() const { return plausible_ && !scatter_.alive; }
  void see_alive(const Rest& rest) { scatter_ = ForceScatter(rest); }
  bool is_loaded(double force_N) const;  // an unloaded cell does not show this force
  double zero_doubt_N() const;  // so much the zero of the cell may drift

  // Orders to the frame
  Plausibility::Motion motion_now(double direction, double speed_m_s) const;  // and is allowed
  void begin(const Plausibility::Motion& motion);
  void begin_hold();  // of a force, with its loop
  void stand(std::optional<double> travel_m = std::nullopt);
  void look_away() {
    if (plausible_) plausible_->look_away();
  }
  void zero_force() {
    if (plausible_) plausible_->zero_force(setup_.clock.now());
  }
  void distrust_force() {
    if (plausible_) plausible_->distrust_force();
  }

  // Samples of the frame
  std::optional<Contradiction> check(const FrameSample& sample);
  // Below the lower limit of force: nullopt if the specimen may pull at the probe.
  std::optional<Contradiction> check_fall(const FrameSample& sample) const;
  // `target` is the frame's word. What it shows has to agree, at the latest in the samples that
  // come next. Errors: refused.
  Task<Result<>> believe(const MotionOrder& order, const MotionOutcome& outcome) const;

  // The contact, as far as its stiffness was measured
  void know_contact(double travel_m, double felt_N, double stiffness_N_m);
  void forget_contact() {
    if (plausible_) plausible_->press().forget();
  }
  void zero_travel(double travel_m);  // this travel is 0 from now on; contact is not known there
  bool knows_contact() const { return plausible_ && plausible_->press().knows(); }
  // Travel at which a motion to this force has to stand, if that is known.
  std::optional<double> furthest_m(double force_N) const;

 private:
  std::string disagreement(const MotionOrder& order, const MotionOutcome& outcome) const;

  const RunSetup& setup_;
  const EventLog& log_;
  const Guard& guard_;
  Pressing* pressing_;
  const FrameView& view_;
  std::optional<Plausibility> plausible_;
  ForceScatter scatter_;  // all that was seen of the unloaded cell
  double drift_N_s_ = 0;  // of the cell, a magnitude, as far as it is known
  std::optional<Rest> rest_, bare_;
  double moved_zero_N_ = 0;  // since bare_ was seen
};

}  // namespace lcrig
