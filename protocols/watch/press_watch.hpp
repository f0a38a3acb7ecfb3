// SPDX-License-Identifier: Apache-2.0
// The force against the way into the specimen: a contact whose stiffness was measured pushes back,
// and a cell that does not show it is not believed, however much it scatters. Part of Plausibility.
// Pure logic.
#pragma once

#include <optional>
#include <string>

#include "base/time.hpp"

namespace lcrig {

class PressWatch {
 public:
  // Contact was found at this travel, felt so much beyond rest, and is at least so stiff there.
  void know(MonoTime now, double travel_m, double felt_N, double stiffness_N_m);
  // Contact is somewhere else now, or nobody knows where.
  void forget() { contact_.reset(); }
  bool knows() const { return contact_.has_value(); }

  struct Motion {
    Motion() = default;
    double felt_N = 0;  // at its begin, beyond rest
    double speed_m_s = 0;  // a frame that brakes presses no deeper, and the force relaxes
    // Rate at which this force relaxes, as far as it was seen. Unknown: it may lose a third at
    // once.
    std::optional<double> relaxes_N_s;
    bool holds = false;  // a force: the specimen may creep, and the frame follows
  };
  void begin(const Motion& motion, MonoTime now);
  // `felt_N`: beyond rest. `tolerance_N`: what the cell may be off by. `doubt_m`: what the travel
  // may be off by. The answer is for people.
  std::optional<std::string> check(MonoTime t, double travel_m, double felt_N, double tolerance_N,
                                   double doubt_m);
  // A sample while the frame stands, which may have relaxed meanwhile.
  void rest(double travel_m, double felt_N);
  // Where `felt_N` is reached at the latest, if a motion begins now; nullopt: not known.
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
    double deepest_m;  // of this run
    double there_N;  // the last force felt at that depth
  };
  double least_N(MonoTime t, double travel_m, double doubt_m) const;
  double relaxed_N(MonoTime t) const;
  double least_since_then_N(double travel_m, double felt_N, double tolerance_N, bool is_in);
  double from_m(MonoTime t, double doubt_m) const;
  double near_N() const;

  std::optional<Contact> contact_;
  Motion motion_;
  MonoTime begun_{}, last_{};
  double base_m_ = 0, base_N_ = 0;  // from where on the force has to rise, and from what
  bool loaded_ = false;  // it began there
  double crept_m_ = 0;
  std::optional<double> beyond_N_, best_N_;  // the force beyond the least rise; its largest,
  MonoTime best_at_{};  // and when and where that was
  double best_m_ = 0;
  std::optional<double> travel_m_;  // the last one
  int short_of_ = 0;  // samples that show too little, one after another
};

}  // namespace lcrig
