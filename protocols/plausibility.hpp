// SPDX-License-Identifier: Apache-2.0
// What cannot be true of a frame's samples, given what it was told to do: digits that never change,
// a drive that runs the wrong way or not at all, a force that falls while the probe presses, a
// frame that moves while nobody told it to. Limits are the guard's; here only the contradictions.
// Pure logic: the run feeds it and stops the frame when it answers.
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "drivers/load_frame.hpp"
#include "protocols/watch_figures.hpp"

namespace lcrig {

// What is not believed any more, and so what is still allowed.
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
  // Known better now; what is under way goes on.
  void set_figures(WatchFigures figures) { figures_ = figures; }

  struct Motion {
    Motion() = default;
    double direction = 0;  // +1: towards the specimen; 0: the force loop goes where it has to
    double speed_m_s = 0;  // of the force loop: of its approach
    double rate_N_s = 0;  // of the force loop's ramp; 0: it holds
    double force_N = 0;  // at its begin, as it is shown
    double rest_N = 0;  // of an unloaded cell
    // So much the force may fall on the way towards the specimen, or rise on the way back; and so
    // much more with time, for a cell that is known to drift.
    double against_N = 0, drift_N_s = 0;
  };
  // The command is on its way; from now on the frame may move.
  void begin(const Motion& motion, MonoTime now);
  // From now on the force proves nothing: only the travel is looked at.
  void distrust_force() { force_believed_ = false; }
  // The zero of the force is another one, as it was told to be; what moves is watched on.
  void zero_force(MonoTime now);
  // It stands, by its own word.
  void stand(MonoTime now);
  // Whatever happens now is no news: it is being stopped, or nobody knows what it does.
  void look_away();
  // A specimen may pull at a probe that stands, or goes away; never at one that comes nearer.
  bool may_pull() const { return state_ != State::moving || motion_.direction <= 0; }

  std::optional<Contradiction> check(const FrameSample& sample);

 private:
  enum class State { unknown, moving, standing };
  std::optional<Contradiction> check_digits(const FrameSample& sample);
  std::optional<Contradiction> check_direction(double travel_m);
  std::optional<Contradiction> check_force(MonoTime t, double force_N) const;
  std::optional<Contradiction> check_progress(const FrameSample& sample);
  std::optional<Contradiction> check_stillness(const FrameSample& sample);
  std::optional<Contradiction> check_step(MonoTime t, double force_N);
  void learn_digit(std::optional<double> travel_m);
  double stall_s() const;
  void mark(const FrameSample& sample);

  WatchFigures figures_;
  State state_ = State::unknown;
  bool force_believed_ = true;
  Motion motion_;
  MonoTime since_{};  // of this state
  MonoTime zeroed_{};  // of the force
  std::optional<double> furthest_m_;  // of this motion, in its direction
  struct Mark {
    Mark() = default;
    MonoTime t;
    std::optional<double> travel_m, force_N;
  };
  std::optional<Mark> progress_;  // where the present look for progress began
  int idle_quarters_ = 0;  // looks without any, one after another
  std::optional<double> last_travel_m_;
  double digit_m_ = 0;  // the least difference of two travels so far; 0: none
  std::optional<double> stood_m_;
  int moving_flags_ = 0;  // one after another, standing
  std::optional<double> last_force_N_;
  std::int64_t equals_ = 0;
  struct Seen {
    Seen(MonoTime at, double f) : t(at), force_N(f) {}
    MonoTime t;
    double force_N;
  };
  std::deque<Seen> recent_;  // forces of the last second, standing
  MonoTime compared_{};
};

}  // namespace lcrig
