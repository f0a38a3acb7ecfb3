// SPDX-License-Identifier: Apache-2.0
// Checks the limits of a protocol on every sample, in parallel with every step. Pure logic: the run
// passes it the samples, and stops the frame when it reports a violation.
#pragma once

#include <optional>
#include <string>

#include "base/time.hpp"
#include "drivers/load_frame.hpp"
#include "protocols/plan/limits.hpp"

namespace lcrig {

class Guard {
 public:
  // No sample may lie outside `limits`.
  Guard(const BoundLimits& limits, Duration stale_after, ForceClass cell)
      : limits_(limits), stale_after_(stale_after), cell_(cell) {}

  // Why this sample must stop the run; nullopt: it is within the limits.
  std::optional<std::string> check(const FrameSample& sample);
  // Missing samples must stop the run, too, while the frame may move.
  std::optional<std::string> check_age(MonoTime now) const;

  // From now on the gap limits apply, as a window of travel.
  void place_contact(double contact_travel_m) { limits_.place_contact(contact_travel_m); }
  // The frame stands at this travel, which becomes 0. Samples with the old zero may still arrive.
  void zero_travel(double travel_m);
  // An unloaded cell that shows less than zero hides that much of the true force, so the upper
  // limit is lowered by it. A force within the noise (`noise_N`: scatter of a sample) lowers
  // nothing.
  void set_rest_force(double force_N, double noise_N);
  // The force was zeroed while the probe pressed with `hidden_N`. The lower limit is lowered by it,
  // because the unloaded cell shows minus that force without any pull. 0: it was zeroed without
  // load. The upper limit stays, because `zero` bounds the sum of all hidden forces.
  void set_zero_under_load(double hidden_N);
  // Somebody else changed the zero of force or travel. From now on every force that the cell can
  // show is allowed, but no motion except away from the specimen.
  void distrust_zero(double cell_N);
  bool is_distrusted() const { return distrusted_; }
  const BoundLimits& limits() const { return limits_; }
  double force_max_N() const { return limits_.force_max_N + offset_N_; }

  // The run is being stopped. No sample is judged until the frame stands.
  void expect_standstill() { mode_ = Mode::stopping; }
  // The frame stands, and the way back begins. It allows forces up to the largest one of the run,
  // and travels between here and the limits; without a valid force, only smaller travels.
  void allow_return(double noise_N);
  // Takes the frame's report of its standstill like a sample, because the last sample may still
  // belong to the motion.
  void take_standstill(std::optional<double> force_N, std::optional<double> travel_m);
  // The force was below its lower limit when the frame stood: the specimen pulls at the probe, and
  // no motion is known to be safe.
  bool is_pulled() const { return last_force_N_ && *last_force_N_ < limits_.force_min_N; }

  // Off for a passive protocol or a rod with weights, which may send no samples.
  void set_watch_age(bool on) { watch_age_ = on; }
  void restart_age(MonoTime now) { last_ = travel_seen_ = now; }
  double peak_force_N() const { return peak_force_N_; }

 private:
  enum class Mode { watching, stopping, returning };
  std::optional<std::string> check_force(double force_N) const;
  std::optional<std::string> check_travel(double travel_m);
  std::optional<std::string> check_travel_age(MonoTime now) const;
  std::optional<std::string> check_blind(const FrameSample& sample) const;

  BoundLimits limits_;
  Duration stale_after_;
  ForceClass cell_;
  std::optional<MonoTime> last_, travel_seen_;  // times of the last force and of the last travel
  bool watch_age_ = false;
  Mode mode_ = Mode::watching;
  double offset_N_ = 0, hidden_N_ = 0;
  bool distrusted_ = false;
  double peak_force_N_ = 0;
  std::optional<double> last_force_N_, last_travel_m_;
  double noise_N_ = 0;  // of a sample, at the start of the way back
  std::optional<double> stood_m_;
  std::optional<double> old_zero_m_;  // until a sample shows the new zero
};

}  // namespace lcrig
