// SPDX-License-Identifier: Apache-2.0
// Finds samples that cannot be true, given the orders to the frame: digits that never change, a
// drive that runs the wrong way or not at all, a force that falls while the probe presses, a frame
// that moves without an order. The limits are checked by Guard. Pure logic: the run passes it the
// samples, and stops the frame when it reports a contradiction.
#pragma once

#include <cmath>
#include <deque>
#include <optional>
#include <string>

#include "drivers/load_frame.hpp"
#include "protocols/watch/press_watch.hpp"
#include "protocols/watch/watch_figures.hpp"

namespace lcrig {

// What is no longer believed. It decides what is still allowed.
enum class Disbelief {
  force,  // the cell: only motion away from the specimen is certain to unload it
  drive,  // it disobeys: no motion at all until a person has looked
  stillness,  // it moved without an order: it is stopped, and may move away under watch
};

struct Contradiction {
  Contradiction(Disbelief d, std::string w) : disbelief(d), why(std::move(w)) {}
  Disbelief disbelief;
  std::string why;
};

class Plausibility {
 public:
  explicit Plausibility(WatchFigures figures) : figures_(figures) {}
  const WatchFigures& figures() const { return figures_; }
  // Better figures, which apply to a current motion at once.
  void set_figures(WatchFigures figures) { figures_ = figures; }

  struct Motion {
    Motion() = default;
    double direction = 0;  // +1: towards the specimen; 0: the force loop decides
    double speed_m_s = 0;  // for the force loop: of its approach
    double rate_N_s = 0;  // for the force loop: rate of its ramp; 0: it holds
    double force_N = 0;  // shown force at the beginning
    bool force_known = true;  // false: the first force shown counts as that at the beginning
    double rest_N = 0;  // of the unloaded cell
    // The most that the cell shows once a specimen that pulls at the probe has let go.
    std::optional<double> free_N;
    // The largest fall of the force that is allowed while moving towards the specimen, or rise
    // while moving away; and its growth with time, for a cell that is known to drift.
    double against_N = 0, drift_N_s = 0;
    double waver_N = 0;  // of a force loop, to either side
    std::optional<double> target_m;  // end of the motion; a servo may overshoot it and come back
    bool holds = false;  // holds a force until the next order
    // The largest force that was predicted for it; nullopt: it does not press. The cell may show it
    // only some time after the frame stands.
    std::optional<double> worst_N;
    Duration shown_after{};
  };
  // The order is being sent; from now on the frame may move.
  void begin(const Motion& motion, MonoTime now);
  // From now on the force proves nothing, and only the travel is checked.
  void distrust_force() { force_believed_ = false; }
  // The run itself zeroed the force. A current motion is still watched.
  void zero_force(MonoTime now);
  // The frame reports standstill, and perhaps at which travel.
  void stand(MonoTime now, std::optional<double> travel_m = std::nullopt);
  // Suspends all checks until the next `begin` or `stand`: the frame is being stopped, or its state
  // is unknown.
  void look_away();
  // Whether the specimen may pull at the probe. It may if the probe stands or moves away, but never
  // if the probe comes closer.
  bool may_pull() const { return state_ != State::moving || motion_.direction <= 0; }
  // True when the last two forces differ only in their sign, and a contact of this stiffness does
  // not explain that by the way between them. Then the cell is wrong. Any other fall may come from
  // a specimen that pulls.
  bool changed_sign(double stiffness_N_m) const;
  // The watch of the force against the depth in the contact.
  PressWatch& press() { return press_; }
  const PressWatch& press() const { return press_; }
  double travel_doubt_m() const;
  // What the travel of a standing frame may differ by: noise, digit, and the hunting of its loop.
  double still_m() const;
  // Scatter of the force while the frame stands and its controller hunts: standard deviation of a
  // sample about the ones just before it.
  double wavers_N() const { return std::sqrt(wavers_N2_); }

  std::optional<Contradiction> check(const FrameSample& sample);

 private:
  enum class State { unknown, moving, standing };
  std::optional<Contradiction> check_digits(const FrameSample& sample);
  std::optional<Contradiction> check_direction(double travel_m);
  std::optional<Contradiction> check_begin(MonoTime t, double travel_m);
  std::optional<Contradiction> check_force(MonoTime t, double force_N);
  std::optional<Contradiction> check_press(const FrameSample& sample);
  std::optional<Contradiction> check_progress(const FrameSample& sample);
  std::optional<Contradiction> check_stillness(const FrameSample& sample);
  std::optional<Contradiction> check_step(MonoTime t, double force_N);
  void learn_digit(std::optional<double> travel_m);
  void see_end_of_motion(MonoTime now);
  void follow_filter(MonoTime t, double force_N);
  bool may_still_fall(MonoTime t) const;
  double stall_s() const;
  std::optional<double> relaxes_N_s() const;
  void see_relaxation(MonoTime t, double force_N);
  void remember(const FrameSample& sample);
  void mark(const FrameSample& sample);

  WatchFigures figures_;
  State state_ = State::unknown;
  bool force_believed_ = true;
  Motion motion_;
  MonoTime since_{};  // start of this state
  MonoTime zeroed_{};  // when the force was last zeroed
  std::optional<double> furthest_m_;  // of this motion, in its direction
  std::optional<double> peak_N_, before_N_;  // of this motion: largest force; previous force
  int fallen_ = 0;  // consecutive forces far below the peak
  // Until then the force of the last motion that pressed may still rise to this.
  MonoTime follows_until_{};
  double follows_to_N_ = 0;
  // Until then the cell may still show how the force fell on the last way away.
  MonoTime falls_until_{};
  PressWatch press_;
  struct Mark {
    Mark() = default;
    MonoTime t;
    std::optional<double> travel_m, force_N;
  };
  std::optional<Mark> progress_;  // start of the current check of progress
  int idle_quarters_ = 0;  // consecutive checks without progress
  std::optional<double> last_travel_m_;
  double digit_m_ = 0;  // smallest difference of two travels so far; 0: none
  std::optional<double> stood_m_;  // as its samples show
  std::optional<double> said_m_;  // as it reported, until a sample was compared with it
  int moving_flags_ = 0;  // consecutive samples that claim motion at standstill
  std::optional<double> last_force_N_;
  std::int64_t equals_ = 0;
  struct Seen {
    Seen(MonoTime at, double f) : t(at), force_N(f) {}
    MonoTime t;
    double force_N;
  };
  std::deque<Seen> recent_;  // forces of the last second at standstill
  double wavers_N2_ = 0;
  std::optional<Seen> stood_first_, stood_last_;  // smoothed, since the force settled
  struct Place {
    Place(double f, std::optional<double> x) : force_N(f), travel_m(x) {}
    double force_N;
    std::optional<double> travel_m;
  };
  std::optional<Place> place_, place_before_;  // at the last two forces
  MonoTime compared_{};
};

}  // namespace lcrig
