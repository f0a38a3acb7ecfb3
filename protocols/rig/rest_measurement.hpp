// SPDX-License-Identifier: Apache-2.0
// Measures a frame at standstill: mean and scatter of the force, and whether it stands at all. Used
// by RestMeter and all checks of a run, whose tolerances are derived from it.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/online.hpp"
#include "drivers/load_frame.hpp"
#include "protocols/rig/constants.hpp"

namespace lcrig {

// A scatter that was estimated from few samples may be far too small: that of 18 samples was once
// 0.45 of the true one. This one is so much larger that the rate above holds for it, too.
double sure_scatter_N(double scatter_N, double freedoms);

// How many times the scatter of a look another look at the same cell may find, if each has so many
// degrees of freedom. More is found in fewer than one of 1000 pairs of looks.
double scatter_anew(double freedoms);

class RestMeasurement {
 public:
  RestMeasurement() = default;
  // `from_sample`: how many samples the run had before.
  explicit RestMeasurement(std::int64_t from_sample) : from_sample_(from_sample) {}
  void add(std::span<const FrameSample> samples);
  std::int64_t from_sample() const { return from_sample_; }
  std::int64_t samples() const { return samples_; }

  std::optional<MonoTime> begin() const { return begin_; }  // time of its first sample
  std::int64_t forces() const { return force_.count; }
  double force_N() const { return force_.mean; }
  double scatter_N() const;  // standard deviation of a sample; 0 for fewer than two
  // Standard error of the mean.
  double error_N() const {
    return forces() > 0 ? scatter_N() / std::sqrt(static_cast<double>(forces())) : 0;
  }
  // Drift of the mean, by a straight line through the samples, and its standard error; 0 and
  // infinite for fewer than three samples.
  double drift_N_s() const;
  double drift_error_N_s() const;
  // Whether the drift is beyond doubt.
  bool drifts() const { return std::abs(drift_N_s()) > kBoundSigmas * drift_error_N_s(); }
  // Takes the drift since the rest `before`, measured `ago`: more accurate than within one rest.
  void know_drift(const RestMeasurement& before, Duration ago);
  struct KnownDrift {
    double drift_N_s = 0, error_N_s = 0;
  };
  void know_drift(const KnownDrift& drift) { known_drift_ = drift; }
  const std::optional<KnownDrift>& known_drift() const { return known_drift_; }
  // Shifts the mean, e.g. by the drift over some time.
  void shift(double force_N) { force_.mean += force_N, shifted_N_ += force_N; }
  double shifted_N() const { return shifted_N_; }
  // No real cell repeats its last digit for ever. One that does is frozen or not connected.
  bool is_alive() const { return different_ > 0; }
  double digit_N() const { return digit_N_; }  // smallest difference of two samples; 0: none
  std::int64_t longest_run() const { return longest_run_; }  // of consecutive equal forces
  std::optional<double> travel_m() const;  // mean
  // Standard deviation about a straight line. 0 if the travel shows at most two values, because a
  // flipping last digit is no scatter.
  double travel_scatter_m() const;
  // True if the travel stays within 10 um plus its jitter, and no flag says that the frame moves.
  bool stands() const;
  template <EventKind kind>
  LookAtRest<kind> event() const {
    return {force_N(), scatter_N(), forces(), travel_m()};
  }

 private:
  double travel_jitter_m() const;
  void compare_digits(double force_N);
  double disunity_N_s() const;
  double correlation() const;  // factor on the error of the mean, compared with independent samples

  std::int64_t different_ = 0;
  std::int64_t run_ = 0, longest_run_ = 0;
  double digit_N_ = 0;
  RunningMean force_, time_;  // of the samples with a force; N, s
  double products_ = 0;  // sum of products of both about their means, N s
  std::optional<MonoTime> begin_;
  std::optional<KnownDrift> known_drift_;
  double shifted_N_ = 0;
  std::int64_t from_sample_ = 0, samples_ = 0;
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

}  // namespace lcrig
