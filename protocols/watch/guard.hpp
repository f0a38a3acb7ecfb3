// SPDX-License-Identifier: Apache-2.0
// The limits of a protocol, checked on every sample in parallel with every step. Pure logic: the
// run feeds it and stops the frame when it answers.
#pragma once

#include <optional>
#include <string>

#include "base/time.hpp"
#include "drivers/load_frame.hpp"
#include "protocols/plan/limits.hpp"

namespace lcrig {

class Guard {
 public:
  // No sample may leave the window of the limits.
  Guard(const BoundLimits& limits, Duration stale_after)
      : limits_(limits), stale_after_(stale_after) {}

  // Why this sample must stop the run; nullopt when all is well.
  std::optional<std::string> check(const FrameSample& sample);
  // Samples that stop coming are as bad as wrong ones while the frame may move.
  std::optional<std::string> check_age(MonoTime now) const;

  // The gap limits now make a window of travel, and it counts from here on.
  void place_contact(double contact_travel_m) { limits_.place_contact(contact_travel_m); }
  // The frame stands at this travel, which is 0 from now on; samples from before may still come.
  void zero_travel(double travel_m);
  // An unloaded cell that shows less than zero hides as much of the true force: the upper limit is
  // lowered by it. What is within the noise (`noise_N`: scatter of a sample) lowers nothing.
  void set_rest_force(double force_N, double noise_N);
  // The force was zeroed while the probe pressed with this much: the specimen pulls only below
  // that. 0: it was zeroed without load. The upper limit stays: `zero` bounds what all zeros may
  // hide.
  void set_zero_under_load(double hidden_N);
  // The zero of force or travel was changed by somebody else. From now on every force is allowed
  // that the cell can show, but no motion except away from the specimen.
  void distrust_zero(double cell_N);
  bool is_distrusted() const { return distrusted_; }
  const BoundLimits& limits() const { return limits_; }
  double force_max_N() const { return limits_.force_max_N + offset_N_; }

  // The run is being stopped: until the frame stands no sample is judged.
  void expect_standstill() { mode_ = Mode::stopping; }
  // The frame stands, and the way back begins. Allowed are forces up to the largest one of the run,
  // and travels between here and the limits; without a valid force only less travel.
  void allow_return(double noise_N);
  // Where the frame reports that it stands. It counts like a sample: the last sample may still be
  // one of the motion.
  void take_standstill(std::optional<double> force_N, std::optional<double> travel_m);
  // The force was below its lower limit when the frame stood: the specimen holds on to the probe,
  // and no motion is known to be safe.
  bool is_pulled() const { return last_force_N_ && *last_force_N_ < limits_.force_min_N; }

  // A passive protocol or a rod with weights has nothing that could go stale.
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
  std::optional<MonoTime> last_, travel_seen_;  // a force, a travel
  bool watch_age_ = false;
  Mode mode_ = Mode::watching;
  double offset_N_ = 0, hidden_N_ = 0;
  bool distrusted_ = false;
  double peak_force_N_ = 0;
  std::optional<double> last_force_N_, last_travel_m_;
  double noise_N_ = 0;  // of a sample, where the return began
  std::optional<double> stood_m_;
  std::optional<double> old_zero_m_;  // until a sample shows the new one
};

}  // namespace lcrig
