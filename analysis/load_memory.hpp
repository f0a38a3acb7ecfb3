// SPDX-License-Identifier: Apache-2.0
// What a specimen that creeps remembers of its loads: for elements with several time constants, the
// pressure to which each has yielded (q' = (P - q) / time). Private to analysis/.
#pragma once

#include <cstddef>
#include <unordered_map>
#include <vector>

#include "analysis/metrics.hpp"

namespace lcrig {

class LoadMemory {
 public:
  // Follows the force of all samples of the run and keeps the state at these readings, which are in
  // the order of time. Without samples of the frame it knows nothing.
  LoadMemory(const RunView& view, double Pa_per_N, const std::vector<std::size_t>& readings);

  // What yields faster cannot be told from an elastic answer. Empty: the history is not known.
  const std::vector<double>& times_s() const { return times_s_; }
  struct State {
    std::vector<double> memory_Pa;
    double held_decades = 0;  // log10(1 + time since the load was reached, in s)
  };
  // Precondition: the reading is one of those.
  const State& at(std::size_t reading) const { return states_.at(reading); }

 private:
  std::vector<double> times_s_;
  std::unordered_map<std::size_t, State> states_;
};

}  // namespace lcrig
