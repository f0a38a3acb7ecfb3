// SPDX-License-Identifier: Apache-2.0
// What a frame shows while it stands: mean and scatter of the force, and whether it stands at all.
// Tolerances of a run are derived from it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/load_frame.hpp"

namespace lcrig {

class Rest {
 public:
  void add(std::span<const FrameSample> samples);

  std::int64_t forces() const { return n_; }
  double force_N() const { return mean_; }
  double scatter_N() const;  // standard deviation of a sample; 0 for fewer than two
  double error_N() const;  // standard error of the mean
  // No real cell repeats its last digit for ever; one that does is frozen, or not connected.
  bool is_alive() const { return different_ > 0; }
  std::optional<double> travel_m() const;  // mean
  bool stands() const;  // within 10 um, and no flag says that it moves
  std::string to_json_text() const;

 private:
  std::int64_t n_ = 0, different_ = 0;
  double mean_ = 0, squares_ = 0;  // Welford
  std::optional<double> last_N_;
  std::int64_t travels_ = 0;
  double travel_sum_m_ = 0, travel_min_m_ = 0, travel_max_m_ = 0;
  bool moving_ = false;
};

// The smallest step between two travels that differ: the resolution as far as it was seen.
class TravelStep {
 public:
  void add(std::optional<double> travel_m);
  double step_m() const { return step_m_.value_or(0); }

 private:
  std::optional<double> last_m_, step_m_;
};

}  // namespace lcrig
