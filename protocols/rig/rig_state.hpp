// SPDX-License-Identifier: Apache-2.0
// What a run knows of its rig, each fact once: cell, contact, frame, and what may be trusted. A
// value that changes only by inputs, which are stored, and by samples, so the state of a stored run
// can be made again (run/watch_replay.hpp). Corridors, permits and checks are functions of it. Time
// is that of the samples; there is no clock inside.
#pragma once

#include <optional>
#include <string>

#include "base/result.hpp"
#include "events/payloads.hpp"
#include "protocols/rig/cell.hpp"
#include "protocols/rig/contact.hpp"
#include "protocols/rig/course.hpp"
#include "protocols/rig/forecast.hpp"
#include "protocols/rig/last_seen.hpp"
#include "protocols/rig/prediction.hpp"
#include "protocols/rig/rig_facts.hpp"
#include "protocols/rig/tolerances.hpp"

namespace lcrig {

enum class FrameMotion { unknown, moving, standing };
// `stopping`: no sample is judged until the frame stands. `finally`: it may only retreat.
enum class RunPhase { steps, stopping, finally, ended };

// What the frame was ordered, and what it shows.
struct FrameState {
  FrameCapabilities caps;  // travels count from the present zero
  FrameMotion motion = FrameMotion::unknown;
  MonoTime since{};  // start of this state
  Order order;  // while it moves
  std::optional<double> reported_m;  // where it stands, until a sample was compared with it
  // A zero of the travel was ordered: from then on samples show the new one, and it stands.
  std::optional<MonoTime> stands_from;
  int travel_zeros = 0;  // that this run asked for
  double zero_m = 0;  // the present zero of travel, counted from the one at the start of the run
  LastSeen seen;  // by its samples; its travel also from the report of a standstill
  std::optional<double> force_N;  // the last known one
  MonoTime force_at{};  // when it was known
  MonoTime zeroed_at{};  // when this run zeroed it last
  // From the samples alone.
  std::optional<double> shown_force_N, shown_travel_m;
  std::optional<double> end_force_N;  // where the last motion ended
  std::optional<MonoTime> last_sample;
  bool overloaded = false;  // the cell, in the last sample
};

struct Trust {
  bool force = true;  // what the cell shows counts
  std::optional<std::string> no_pressing;  // why nothing may be pressed any more
  std::optional<Error> no_motion;  // why nothing may be moved any more
  // Errors: limit_tripped; that of `no_motion`.
  Result<> may_press() const;
  Result<> may_move() const;
};

class RigState {
 public:
  // `forecast`: absent for a frame that cannot move.
  RigState(RigFacts facts, std::optional<Forecast> forecast);

  // What an input made known.
  struct Applied {
    std::optional<ForceComparison> compared;
    bool tolerances = false;  // they are new
  };
  // `rest`: the rest measurement that it names; nullptr: none.
  Applied apply(const WatchInputEvent& input, const RestMeasurement* rest, MonoTime at);
  // Returns a late comparison of the last motion that pressed.
  std::optional<ForceComparison> apply(const FrameSample& sample);
  // What is wrong with the state itself; nullopt: nothing.
  std::optional<std::string> broken_invariant() const;

  RigFacts facts;
  BoundLimits limits;  // at the present zeros, with the gap limits once contact is known
  Cell cell;
  Contact contact;
  FrameState frame;
  Trust trust;
  Course course;
  Tolerances tolerances;
  std::optional<Forecast> forecast;
  RunPhase phase = RunPhase::steps;
  bool is_prepared = false;  // its samples are judged
  bool is_stop_pending = false;  // a stop was requested and has not run yet
  bool watches_age = false;  // missing samples stop the run

  // Whether samples are compared with orders: this run moves the frame.
  bool is_watched() const { return forecast && facts.commands; }
  double force_max_N() const { return limits.force_max_N - cell.below_zero_N; }
  // By how much the zero of the cell may err, by its class.
  double zero_uncertainty_N() const;
  bool is_loaded(double force_N) const;  // whether the force is more than an unloaded cell shows
  bool is_pulled(double force_N) const;  // whether it is less, whatever the cell's zero does
  // The force was below its lower limit when the frame stood: the specimen pulls at the probe.
  bool stood_pulled() const;
  // True until the cell was seen to be alive. No motion may press before that.
  bool needs_live_cell() const { return is_watched() && !cell.noise.alive; }
  // The last known force is the present one. It is older while the cell is overloaded, and when
  // samples come without a force.
  bool shows_force() const;
  // The resolution of the travel: as stated, else the finest change that was seen; 0: unknown.
  double travel_step_m() const;
  double travel_step_at_most_m() const;  // the same; if unknown, the coarsest that there may be
  double travel_tolerance_m() const;  // of a depth in the contact
  // What the travel of a standing frame may differ by: noise, step, and the hunting of its loop.
  double still_m() const;
  double standing_m() const;  // the same from where it stood
  double standing_noise_N() const;  // of the force while the frame stands and its loop hunts
  // Whether the specimen may pull at the probe. It may if the probe stands or moves away.
  bool may_pull() const {
    return frame.motion != FrameMotion::moving || frame.order.direction <= 0;
  }
  // While the frame approaches, the cell may still show how the force fell on the last retreat.
  bool may_still_fall(MonoTime t) const {
    return frame.order.direction > 0 && t <= course.falls_until;
  }
  // The rate at which the force relaxed while the frame stood, so far; nullopt: not observed.
  std::optional<double> relaxes_N_s() const;
  // How long a motion may show no progress before it counts as stalled, s.
  double stall_s() const;

  // An order that starts now, with its tolerances. `measured_noise_N`: of the force in the last
  // rest measurement; a frame that hunts in contact shows more than the noise of its cell.
  Order order_now(double direction, double speed_m_s, double measured_noise_N) const;
  Order hold_now(double force_N, double measured_noise_N) const;  // by the frame's loop

 private:
  void start(const Order& order, MonoTime at);
  void start_pressing(MonoTime at);
  double loop_runs_on_m() const;
  void stand(MonoTime at, std::optional<double> travel_m);
  void end_motion(MonoTime at);
  bool learn_zero(const RestMeasurement& rest, bool is_unloaded);
  bool learn_noise(const RestMeasurement& rest);
  void invalidate_force();
  void place_contact(double travel_m, double force_N);
  void zero_force(MonoTime at, const WatchInputEvent& e);
  void zero_travel(double travel_m, MonoTime at);
  void take_standstill(const WatchInputEvent& e, MonoTime at);
  void trust_pressing(const std::optional<ForceComparison>& compared);
  std::optional<ForceComparison> compare(const WatchInputEvent& e);
  bool learn(WatchInput what, const RestMeasurement& rest);
  void apply_fact(const WatchInputEvent& e, MonoTime at);
  void lose_motion();
  void hide(double pressed_N);
  void set_limits_zero(double zero_N, double noise_N);
  void start_retreat(double noise_N);
  double load_tolerance_N() const;

  void see(const FrameSample& sample);
  void see_moving(const FrameSample& sample);
  void see_standing(const FrameSample& sample);
  void see_order_force(MonoTime t, double force_N);
  void see_pressed(const FrameSample& sample);
  void see_loop(const FrameSample& sample);
  void see_progress(const FrameSample& sample);
  void see_relaxation(MonoTime t, double force_N);
  void see_jump(const FrameSample& sample);
  void see_claim(const FrameSample& sample);
  void see_deepest(double travel_m, double force_N);
  void follow_filter(MonoTime t, double force_N);

  ForcePrediction prediction_;
};

}  // namespace lcrig
