// SPDX-License-Identifier: Apache-2.0
// What a run remembers of the course of the samples, as far as corridors and checks need it. Only
// RigState::apply writes it.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "base/time.hpp"

namespace lcrig {

struct Course {
  struct Seen {
    Seen(MonoTime at, double f) : t(at), force_N(f) {}
    MonoTime t;
    double force_N;
  };
  struct Place {
    Place(double f, std::optional<double> x) : force_N(f), travel_m(x) {}
    double force_N;
    std::optional<double> travel_m;
  };

  // Always.
  std::int64_t equal_forces = 0;  // consecutive ones
  std::optional<double> last_N, last_travel_m;
  double finest_step_m = 0;  // smallest change of the travel; 0: none
  std::optional<Place> place, place_before;  // at the last two forces
  double peak_force_N = 0;  // of the run, until its retreat
  bool is_force_known = false;  // false also after an overload, until a force is shown
  std::optional<MonoTime> force_at, travel_at;  // when they were shown last
  std::optional<double> old_zero_m;  // of the travel, until a sample shows the new one

  // The filter of the cell still follows the last motion: upwards until `follows_until`, to
  // `follows_to_N` at most; downwards until `falls_until`.
  MonoTime follows_until{}, falls_until{};
  double follows_to_N = 0;

  // Since the motion started.
  std::optional<double> from_m;  // where the frame reported to stand before it
  std::optional<double> furthest_m;  // in its direction
  double runs_on_m = 0;  // the force loop that it interrupted may still move the frame by this
  std::optional<double> peak_N, before_N;  // largest force; previous force
  int fallen = 0;  // consecutive forces far below the peak
  struct Mark {
    Mark(MonoTime at, double x, double f) : t(at), travel_m(x), force_N(f) {}
    MonoTime t;
    double travel_m, force_N;
  };
  struct Loop {  // the force loop is off its set point, and has to move towards it
    double direction = 0;  // +1: towards the specimen
    double furthest_m = 0;  // in that direction
    double wrong_m = 0;  // from there, against it
  };
  std::optional<Loop> loop;
  std::optional<Mark> progress;  // start of the current part of the time for progress
  int idle = 0;  // consecutive parts without progress
  struct Idle {
    double way_m = 0, seconds = 0;
    bool moves = false;
  } last_idle;

  // The same, pressing a contact whose least stiffness is known.
  struct Pressed {
    MonoTime start{}, last{};
    double start_N = 0;  // beyond zero
    std::optional<double> relaxes_N_s;  // observed before it; nullopt: not observed
    double base_m = 0, base_N = 0;  // travel and force from which the force has to rise
    double zero_N = 0;  // of the cell; what it showed at the start, if nothing could press there
    bool is_loaded = false;  // it started under load
    double crept_m = 0;
    // The force beyond the least rise: the last, and the largest, when and where it was.
    std::optional<double> beyond_N, best_N;
    MonoTime best_at{};
    double best_m = 0;
    int too_small = 0;  // consecutive forces below the corridor
  } pressed;

  // Since the frame stands.
  std::optional<double> stood_m;  // as its samples show
  int moving_flags = 0;  // consecutive samples that report a motion
  std::deque<Seen> recent;  // forces of the last second
  MonoTime compared{};
  std::optional<Seen> stood_first, stood_last;  // smoothed
  double noise_N2 = 0;  // square of the noise about the samples just before

  // On the retreat.
  double retreat_noise_N = 0;
  std::optional<double> retreat_from_m;

  // Of the last sample alone.
  struct Claim {  // it was compared with where the frame reported to stand
    Claim(double reported, double shown, double allowed)
        : reported_m(reported), shown_m(shown), allowed_m(allowed) {}
    double reported_m, shown_m, allowed_m;
  };
  std::optional<Claim> claim;
  struct Jump {
    Jump(double b, double a, bool m) : before_N(b), after_N(a), moves(m) {}
    double before_N, after_N;
    bool moves;  // the travel changed with it, so the force is real
  };
  std::optional<Jump> jump;
};

}  // namespace lcrig
