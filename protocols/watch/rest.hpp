// SPDX-License-Identifier: Apache-2.0
// A frame while it stands: mean and scatter of the force, and whether it stands at all. Tolerances
// of a run are derived from it.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/online.hpp"
#include "drivers/load_frame.hpp"

namespace lcrig {

constexpr double kNoiseSigmas = 5;  // of the noise of a cell: what no sample shows by chance
constexpr double kStanding_m = 10e-6;  // within this a frame that stood has not moved
constexpr double kSureOfDrift = 3;  // standard errors

// The median ignores a few spikes. Reorders the values, of which there is at least one.
double middle(std::vector<double>& values);

class Rest {
 public:
  void add(std::span<const FrameSample> samples);

  std::optional<MonoTime> begin() const { return begin_; }  // of its first sample
  std::int64_t forces() const { return force_.count; }
  double force_N() const { return force_.mean; }
  double scatter_N() const;  // standard deviation of a sample; 0 for fewer than two
  // Standard error of the mean.
  double error_N() const {
    return forces() > 0 ? scatter_N() / std::sqrt(static_cast<double>(forces())) : 0;
  }
  // How fast its mean goes away, by a straight line through the samples, and how well that is known
  // (standard error); 0 and infinite for fewer than three.
  double drift_N_s() const;
  double drift_error_N_s() const;
  // Beyond doubt.
  bool drifts() const { return std::abs(drift_N_s()) > kSureOfDrift * drift_error_N_s(); }
  // The drift follows better from the rest `before`, taken so long ago.
  void know_drift(const Rest& before, Duration ago);
  // Moves the mean to what the drift will make of it after some time.
  void shift(double force_N) { force_.mean += force_N; }
  // No real cell repeats its last digit for ever; one that does is frozen, or not connected.
  bool is_alive() const { return different_ > 0; }
  double digit_N() const { return digit_N_; }  // least difference of two samples; 0: none
  std::int64_t longest_run() const { return longest_run_; }  // of equal forces, one after another
  std::optional<double> travel_m() const;  // mean
  // Standard deviation about a straight line; 0 when the travel shows no more than two values, for
  // a last digit that flips is no scatter.
  double travel_scatter_m() const;
  // Within 10 um and what its travel jitters, and no flag says that it moves.
  bool stands() const;
  template <EventKind kind>
  LookAtRest<kind> event() const {
    return {force_N(), scatter_N(), forces(), travel_m()};
  }

 private:
  double travel_jitter_m() const;
  void compare_digits(double force_N);
  double disunity_N_s() const;
  double correlation() const;  // error of the mean over that of independent samples

  std::int64_t different_ = 0;
  std::int64_t run_ = 0, longest_run_ = 0;
  double digit_N_ = 0;
  RunningMean force_, time_;  // of the samples that have a force; N, s
  double products_ = 0;  // of both about their means, N s
  std::optional<MonoTime> begin_;
  std::optional<double> known_drift_N_s_;
  double known_drift_error_N_s_ = 0;
  std::optional<double> last_N_;
  std::int64_t travels_ = 0;
  double travel_sum_m_ = 0, travel_min_m_ = 0, travel_max_m_ = 0;
  struct Series {
    Series() = default;
    void add(double time_s, double v) { t_s.push_back(time_s), value.push_back(v); }
    std::vector<double> t_s, value;
  };
  Series forces_seen_, travels_seen_;
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

// The last digit of a travel that moves: all changes from step to step are multiples of it. The
// steps themselves say less: at one speed they may all be alike.
class TravelDigit {
 public:
  void begin() { last_m_.reset(), last_step_m_.reset(); }  // a motion
  void add(double travel_m);
  double digit_m() const;  // 0: not known

 private:
  std::optional<double> last_m_, last_step_m_;
  double common_m_ = 0;
  int changes_ = 0;
};

}  // namespace lcrig
