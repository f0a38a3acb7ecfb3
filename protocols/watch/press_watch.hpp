// SPDX-License-Identifier: Apache-2.0
// Compares the force with the way into the specimen. A contact whose stiffness was measured pushes
// back; a cell that does not show this force is not believed, however much it scatters. Pure logic,
// part of Plausibility.
#pragma once

#include <optional>
#include <string>

#include "base/time.hpp"

namespace lcrig {

class PressWatch {
 public:
  // Sets the contact: its travel, the force there beyond rest, and its least stiffness.
  void know(MonoTime now, double travel_m, double felt_N, double stiffness_N_m);
  // The place of contact has changed or is unknown.
  void forget() { contact_.reset(); }
  bool knows() const { return contact_.has_value(); }
  // The least stiffness of the contact, if it is known and this travel lies beyond it; else 0.
  double stiffness_N_m(double travel_m) const {
    return contact_ && travel_m > contact_->travel_m ? contact_->stiffness_N_m : 0;
  }

  struct Motion {
    Motion() = default;
    double felt_N = 0;  // at its beginning, beyond rest
    double speed_m_s = 0;  // a frame that brakes presses no deeper, while the force relaxes
    // Observed rate at which this force relaxes. Unknown: it may lose a third at once.
    std::optional<double> relaxes_N_s;
    bool holds = false;  // holds a force: the specimen may creep, and the frame follows
  };
  void begin(const Motion& motion, MonoTime now);
  // The forces of this motion so far were those of an earlier one, shown late.
  void forget_peak() { beyond_N_.reset(), best_N_.reset(); }
  // Returns words for people if the force is too small. `felt_N` is beyond rest, `tolerance_N` the
  // error of the cell, `doubt_m` the error of the travel.
  std::optional<std::string> check(MonoTime t, double travel_m, double felt_N, double tolerance_N,
                                   double doubt_m);
  // A sample at standstill, where the force may have relaxed.
  void rest(double travel_m, double felt_N);
  // The travel by which a motion that begins now must reach `felt_N`; nullopt: unknown.
  std::optional<double> furthest_m(MonoTime now, double felt_N, double tolerance_N,
                                   double doubt_m) const;

 private:
  struct Contact {
    Contact(MonoTime t, double x_m, double f_N, double k_N_m)
        : since(t),
          travel_m(x_m),
          felt_N(f_N),
          stiffness_N_m(k_N_m),
          deepest_m(x_m),
          there_N(f_N) {}
    MonoTime since;
    double travel_m, felt_N, stiffness_N_m;
    double deepest_m;  // largest travel in this run
    double there_N;  // last force felt at that travel
  };
  double least_N(MonoTime t, double travel_m, double doubt_m) const;
  double relaxed_N(MonoTime t) const;
  double least_since_then_N(double travel_m, double felt_N, double tolerance_N, bool is_in);
  double from_m(MonoTime t, double doubt_m) const;
  double near_N() const;

  std::optional<Contact> contact_;
  Motion motion_;
  MonoTime begun_{}, last_{};
  double base_m_ = 0, base_N_ = 0;  // travel and force from which the force has to rise
  bool loaded_ = false;  // the motion began under load
  double crept_m_ = 0;
  std::optional<double> beyond_N_, best_N_;  // force beyond the least rise: the last, and the
                                             // largest
  MonoTime best_at_{};  // when and where the largest was
  double best_m_ = 0;
  std::optional<double> travel_m_;  // the last travel
  int short_of_ = 0;  // consecutive samples with too small a force
};

}  // namespace lcrig
