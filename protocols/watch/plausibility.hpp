// SPDX-License-Identifier: Apache-2.0
// Finds samples of a frame that cannot be true, given what it was told to do: digits that never
// change, a drive that runs the wrong way or not at all, a force that falls while the probe
// presses, a frame that moves without an order. Limits are the guard's; here only the
// contradictions. Pure logic: the run feeds it and stops the frame when it answers.
#pragma once

#include <cmath>
#include <deque>
#include <optional>
#include <string>

#include "drivers/load_frame.hpp"
#include "protocols/watch/press_watch.hpp"
#include "protocols/watch/watch_figures.hpp"

namespace lcrig {

// The part that is not believed any more, which decides what is still allowed.
enum class Disbelief {
  force,  // the cell: only the way away from the specimen is known to unload it
  drive,  // it does not do what it is told: no motion at all until a person has looked
  stillness,  // it moved though nothing was asked: it is stopped, and may leave under watch
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
  // The figures are known better now. A motion under way is judged by them from here on.
  void set_figures(WatchFigures figures) { figures_ = figures; }

  struct Motion {
    Motion() = default;
    double direction = 0;  // +1: towards the specimen; 0: the force loop goes where it has to
    double speed_m_s = 0;  // of the force loop: of its approach
    double rate_N_s = 0;  // of the force loop's ramp; 0: it holds
    double force_N = 0;  // at its begin, as it is shown
    bool force_known = true;  // else the first force that is shown counts as the one at its begin
    double rest_N = 0;  // of an unloaded cell
    // Largest fall of the force allowed on the way towards the specimen, or rise on the way back;
    // and what is added to it with time, for a cell that is known to drift.
    double against_N = 0, drift_N_s = 0;
    double waver_N = 0;  // of a force loop
    std::optional<double> target_m;  // where it ends; a servo may go beyond, and come back
    bool holds = false;  // a force, until something else is asked
  };
  // The command is on its way; from now on the frame may move.
  void begin(const Motion& motion, MonoTime now);
  // From now on the force proves nothing: only the travel is looked at.
  void distrust_force() { force_believed_ = false; }
  // The force was zeroed as the run asked. A motion is watched as before.
  void zero_force(MonoTime now);
  // The frame says that it stands, at this travel if it says where.
  void stand(MonoTime now, std::optional<double> travel_m = std::nullopt);
  // Samples are not judged until the next `begin` or `stand`: the frame is being stopped, or nobody
  // knows what it does.
  void look_away();
  // A specimen may pull at a probe that stands, or goes away; never at one that comes nearer.
  bool may_pull() const { return state_ != State::moving || motion_.direction <= 0; }
  // The last two forces differ in their sign only, and a contact of this stiffness does not explain
  // that by the way between them. Then the cell is wrong; any other fall may be a specimen that
  // pulls.
  bool changed_sign(double stiffness_N_m) const;
  // Facts about the contact.
  PressWatch& press() { return press_; }
  const PressWatch& press() const { return press_; }
  double travel_doubt_m() const;
  // How much the force wavers while the frame stands, because its controller hunts: standard
  // deviation of a sample about the ones just before.
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
  double stall_s() const;
  std::optional<double> relaxes_N_s() const;
  void see_relaxation(MonoTime t, double force_N);
  void remember(const FrameSample& sample);
  void mark(const FrameSample& sample);

  WatchFigures figures_;
  State state_ = State::unknown;
  bool force_believed_ = true;
  Motion motion_;
  MonoTime since_{};  // of this state
  MonoTime zeroed_{};  // of the force
  std::optional<double> furthest_m_;  // of this motion, in its direction
  std::optional<double> peak_N_, before_N_;  // of this motion; its last force
  int fallen_ = 0;  // forces far below the peak, one after another
  PressWatch press_;
  struct Mark {
    Mark() = default;
    MonoTime t;
    std::optional<double> travel_m, force_N;
  };
  std::optional<Mark> progress_;  // where the present look for progress began
  int idle_quarters_ = 0;  // looks without any, one after another
  std::optional<double> last_travel_m_;
  double digit_m_ = 0;  // the least difference of two travels so far; 0: none
  std::optional<double> stood_m_;  // by its samples
  std::optional<double> said_m_;  // by its word, until a sample has been held against it
  int moving_flags_ = 0;  // one after another, standing
  std::optional<double> last_force_N_;
  std::int64_t equals_ = 0;
  struct Seen {
    Seen(MonoTime at, double f) : t(at), force_N(f) {}
    MonoTime t;
    double force_N;
  };
  std::deque<Seen> recent_;  // forces of the last second, standing
  double wavers_N2_ = 0;
  std::optional<Seen> stood_first_, stood_last_;  // smoothed, since it settled
  struct Place {
    Place(double f, std::optional<double> x) : force_N(f), travel_m(x) {}
    double force_N;
    std::optional<double> travel_m;
  };
  std::optional<Place> place_, place_before_;  // of the last two forces
  MonoTime compared_{};
};

}  // namespace lcrig
