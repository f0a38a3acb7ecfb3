// SPDX-License-Identifier: Apache-2.0
// What a run knows of the contact with the specimen. Travels count from the present zero.
#pragma once

#include <optional>
#include <string>

#include "base/time.hpp"

namespace lcrig {

struct Contact {
  std::optional<double> travel_m;  // machine travel of gap zero
  double force_N = 0;  // force there, beyond zero
  double depth_m = 0;  // from there to gap zero the probe may already touch the specimen

  // Its stiffness at most is in the forecast. At least, once samples have proven it:
  struct Least {
    Least(MonoTime t, double x_m, double f_N, double k_N_m)
        : since(t),
          travel_m(x_m),
          force_N(f_N),
          stiffness_N_m(k_N_m),
          deepest_m(x_m),
          deepest_N(f_N) {}
    MonoTime since;
    double travel_m, force_N, stiffness_N_m;
    double deepest_m;  // largest travel in this run
    double deepest_N;  // last force at that travel, beyond zero
    void zero_travel(double zero_m) { travel_m -= zero_m, deepest_m -= zero_m; }
    // The least stiffness where this travel lies beyond contact; else 0.
    double stiffness_at_N_m(double x_m) const { return x_m > travel_m ? stiffness_N_m : 0; }
  };
  std::optional<Least> least;
  std::string not_measured;  // why no stiffness was measured: ": " and a few words

  std::optional<double> start_travel_m;  // where the frame stood when the run started
  std::optional<double> searched_from_m;  // where a search started that has not found contact

  void forget() {
    travel_m.reset();
    least.reset();
  }
};

}  // namespace lcrig
