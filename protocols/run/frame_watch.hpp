// SPDX-License-Identifier: Apache-2.0
// The watch over the frame: the limits (Guard), whether its samples are valid (FrameTruth), and
// whether a motion pressed as predicted (Pressing). Everybody may read them. Whatever changes their
// state besides the samples is an input, which is stored as an event before it is applied, and can
// be applied again to the watch of a stored run (watch_replay.hpp).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "protocols/run/frame_truth.hpp"

namespace lcrig {

using Comparison = Pressing::Comparison;

class FrameWatch {
 public:
  struct Hooks {
    std::function<MonoTime()> now;
    std::function<void(const WatchInputEvent&)> store;
    FrameTruth::TellFigures figures;
  };
  // `pressing`: nullptr for a frame that cannot move.
  FrameWatch(WatchedRig rig, Pressing* pressing, Hooks hooks);
  FrameWatch(const FrameWatch&) = delete;
  FrameWatch& operator=(const FrameWatch&) = delete;

  const WatchedRig& rig() const { return rig_; }
  const Guard& guard() const { return guard_; }
  const FrameTruth& truth() const { return truth_; }
  const Pressing* pressing() const { return pressing_; }

  // Samples. `begin_sample` counts one; inputs until `end_sample` follow from it.
  std::optional<Comparison> add_pressed(std::span<const FrameSample> samples);
  void begin_sample() { ++samples_, judging_ = true; }
  std::optional<Contradiction> check(const FrameSample& sample);
  std::optional<std::string> check_limits(const FrameSample& sample) {
    return guard_.check(sample);
  }
  void end_sample() { judging_ = false; }

  // The frame's state, and what this run asks of it.
  void set_prepared(bool yes);
  void note_stop_pending(bool yes);
  void order(const Plausibility::Motion& motion);
  void permit(const Pressing::Permit& permit);
  void motion_stood(std::optional<double> force_N, std::optional<double> travel_m);
  void stand(std::optional<double> travel_m = std::nullopt);
  void look_away() { record(WatchInputEvent(WatchInput::motion_unknown)); }
  std::optional<Comparison> compare(const MotionOutcome& outcome, double noise_N);
  void leave_to_loop() { record(WatchInputEvent(WatchInput::force_loop)); }
  void watch_age(bool on);
  void restart_age() { record(WatchInputEvent(WatchInput::age_restarted)); }
  void expect_standstill() { record(WatchInputEvent(WatchInput::stopping)); }
  void allow_return(double noise_N);
  void end() { record(WatchInputEvent(WatchInput::ended)); }

  // The cell.
  void learn_rest(const Rest& rest, FrameTruth::Under under = FrameTruth::Under::nothing);
  void learn_scatter(const Rest& rest) { record(look(WatchInput::noise, rest), &rest); }
  void see_alive(const Rest& rest) { record(look(WatchInput::live_cell, rest), &rest); }
  void learn_unpulled(double force_N) { record_force(WatchInput::zero_before_contact, force_N); }
  void set_rest_force(const Rest& rest);
  void zero_force() { record(WatchInputEvent(WatchInput::force_zeroed)); }
  // A zero under load hides `hidden_N` from the limits, and took `taken_N` from the cell.
  void hide(double hidden_N) { record_force(WatchInput::zero_hides, hidden_N); }
  void take_out(double taken_N) { record_force(WatchInput::zero_took, taken_N); }
  void distrust_force() { record(WatchInputEvent(WatchInput::force_invalid)); }
  void distrust_pressing(std::string why);

  // The contact.
  void place_contact(double travel_m) { record_travel(WatchInput::contact, travel_m); }
  void know_contact(double travel_m, double felt_N, double least_N_m);
  void measured(double felt_N, double most_N_m);
  void zero_travel(double travel_m) { record_travel(WatchInput::travel_zeroed, travel_m); }
  // Words for refusals; no judge depends on them.
  void not_measured(const std::string& why);

  // Applies an input again. `rest`: the rest measurement that it names.
  std::optional<Comparison> apply(const WatchInputEvent& input, const Rest* rest, MonoTime at);
  bool is_prepared() const { return prepared_; }
  bool stop_pending() const { return stop_pending_; }
  bool has_ended() const { return ended_; }
  // For the event at the beginning of a run.
  WatchSetupEvent setup_event() const;

 private:
  std::optional<Comparison> record(WatchInputEvent input, const Rest* rest = nullptr);
  void learn(WatchInput what, const Rest& rest);
  void record_force(WatchInput what, double force_N);
  void record_travel(WatchInput what, double travel_m);
  static WatchInputEvent look(WatchInput what, const Rest& rest);

  const WatchedRig rig_;
  Pressing* const pressing_;
  const Hooks hooks_;
  Guard guard_;
  FrameTruth truth_;
  std::int64_t samples_ = 0;
  bool judging_ = false, prepared_ = false, stop_pending_ = false, ended_ = false;
};

// The rig and the forecast that a stored run began with. Errors: garbled.
Result<WatchedRig> rig_of(const WatchSetupEvent& setup, FrameCapabilities frame);
std::optional<Pressing> pressing_of(const WatchSetupEvent& setup, const WatchedRig& rig);

}  // namespace lcrig
