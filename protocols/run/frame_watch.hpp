// SPDX-License-Identifier: Apache-2.0
// The watch over the frame: the state of the rig, and the checks of its samples. Everybody may read
// the state. Whatever changes it besides the samples is an input, which is stored as an event
// before it is applied, and can be applied again to the state of a stored run (watch_replay.hpp).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "protocols/checks/check.hpp"
#include "protocols/rig/rig_state.hpp"
#include "protocols/run/scoped_flag.hpp"

namespace lcrig {

class FrameWatch {
 public:
  struct Hooks {
    std::function<MonoTime()> now;
    std::function<void(const WatchInputEvent&)> store;
    std::function<void(const Tolerances&)> tolerances;  // new ones
    std::function<void(std::string)> broken;  // an invariant of the state: a fault of this program
  };
  // `forecast`: absent for a frame that cannot move.
  FrameWatch(RigFacts facts, std::optional<Forecast> forecast, Hooks hooks);
  FrameWatch(const FrameWatch&) = delete;
  FrameWatch& operator=(const FrameWatch&) = delete;

  const RigState& rig() const { return rig_; }
  // Takes a sample, and returns what the checks find in it.
  std::vector<Finding> add(FrameSample sample);
  // While the flag lives, inputs follow from the last sample.
  ScopedFlag answer_sample() { return ScopedFlag(answering_); }

  // The frame's state, and what this run asks of it.
  void set_prepared(bool yes);
  void note_stop_pending(bool yes);
  void order(const Order& order) { record(to_input(order)); }
  void permit(const Permit& permit) { record(to_input(permit)); }
  void motion_stood(const MotionOutcome& o) { fact(WatchInput::motion_end, o.force_N, o.travel_m); }
  void stand(std::optional<double> travel_m = std::nullopt) {
    fact(WatchInput::standstill, std::nullopt, travel_m);
  }
  void lose_motion() { fact(WatchInput::motion_unknown); }
  // `noise_N`: of a sample, at most.
  std::optional<ForceComparison> compare(const MotionOutcome& outcome, double noise_N);
  void leave_to_loop() { fact(WatchInput::force_loop); }
  void watch_age(bool on) { record_switch(WatchInput::age_watched, on); }
  void restart_age() { fact(WatchInput::age_restarted); }
  void link_back() { fact(WatchInput::link_back); }
  void start_at(std::optional<double> travel_m) {
    fact(WatchInput::run_start, std::nullopt, travel_m);
  }
  void expect_standstill() { fact(WatchInput::stopping); }
  void start_retreat();
  void end() { fact(WatchInput::ended); }

  // The cell. The zero that limits use is that of the last rest measurement.
  enum class Under { nothing, perhaps_contact };  // what the probe touches
  void learn_zero(const RestMeasurement& rest, Under under = Under::nothing);
  void learn_noise(const RestMeasurement& rest) { learn(WatchInput::noise, rest); }
  void see_alive(const RestMeasurement& rest) { learn(WatchInput::live_cell, rest); }
  void learn_untouched(double zero_N) { fact(WatchInput::zero_before_contact, zero_N); }
  // A zero that this run asked for, of what `before` showed, as of now. `pressed_N`: the force of
  // the probe on the specimen, which it hides from the limits; 0: none, or no zero of the force.
  void zeroed(const RestMeasurement& before, bool force, bool travel, double pressed_N);
  // What the cell shows after it.
  void zero_measured(const RestMeasurement& before, const RestMeasurement& after, double pressed_N);
  void take_over_zeros(bool zeroed, std::optional<double> sum_N);
  void invalidate_force() { fact(WatchInput::force_invalid); }
  void lock_out_pressing(std::string why);
  // From now on nothing moves the frame.
  void lock_out_motion(Error why);

  // The contact. `force_N`: there, beyond zero.
  void place_contact(double travel_m, double force_N) {
    fact(WatchInput::contact, force_N, travel_m);
  }
  void take_over_contact(std::optional<double> travel_m) {
    fact(WatchInput::contact_taken_over, std::nullopt, travel_m);
  }
  void lose_contact() { fact(WatchInput::contact_unknown); }
  void know_depth(double depth_m) { fact(WatchInput::contact_depth, std::nullopt, depth_m); }
  void search_from(std::optional<double> travel_m) {
    fact(WatchInput::search, std::nullopt, travel_m);
  }
  void know_least_stiffness(double travel_m, double felt_N, double least_N_m) {
    fact(WatchInput::least_stiffness, felt_N, travel_m, least_N_m);
  }
  void know_largest_stiffness(double felt_N, double most_N_m) {
    fact(WatchInput::largest_stiffness, felt_N, std::nullopt, most_N_m);
  }
  // Words for refusals; no check depends on them.
  void not_measured(const std::string& why) { rig_.contact.not_measured = ": " + why; }

  // Applies an input again. `rest`: the rest measurement that it names.
  std::optional<ForceComparison> apply(const WatchInputEvent& input, const RestMeasurement* rest,
                                       MonoTime at);
  // For the event at the start of a run.
  WatchSetupEvent setup_event() const;

 private:
  std::optional<ForceComparison> record(WatchInputEvent input,
                                        const RestMeasurement* rest = nullptr);
  void fact(WatchInput what, std::optional<double> force_N = std::nullopt,
            std::optional<double> travel_m = std::nullopt,
            std::optional<double> stiffness_N_m = std::nullopt);
  void learn(WatchInput what, const RestMeasurement& rest);
  void record_switch(WatchInput what, bool on);
  void check_invariants();

  RigState rig_;
  const Hooks hooks_;
  std::int64_t samples_ = 0;
  bool is_broken_ = false, answering_ = false;
};

// The rig and the forecast that a stored run started with. Errors: garbled.
Result<RigFacts> rig_of(const WatchSetupEvent& setup, FrameCapabilities frame);
std::optional<Forecast> forecast_of(const WatchSetupEvent& setup, const RigFacts& facts);

}  // namespace lcrig
