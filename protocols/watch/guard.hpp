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

  // From here on the travel window counts, too, that the gap limits make.
  void place_contact(double contact_travel_m) { limits_.place_contact(contact_travel_m); }
  // The frame stands at this travel, which is 0 from now on; samples from before may still come.
  void zero_travel(double travel_m);
  // What an unloaded cell shows below zero is no room: the true force is that much more.
  // `noise_N`: scatter of a sample; what is within it is none.
  void set_rest_force(double force_N, double noise_N);
  // The zero of force or travel is another one: every force is allowed, and only the way away.
  void distrust_zero(double cell_N);
  bool is_distrusted() const { return distrusted_; }
  const BoundLimits& limits() const { return limits_; }
  double force_max_N() const { return limits_.force_max_N + offset_N_; }

  // The way back. The run is being stopped: nothing that happens until the frame stands is news.
  void expect_standstill() { mode_ = Mode::stopping; }
  // It stands. From here every force is allowed that does not rise above the largest one of the
  // run, and every travel between here and the limits. Without a valid force only less travel is.
  void allow_return(double noise_N);
  // What the frame reports of a standstill is newer than its last sample, which may be one of the
  // motion, and is felt all the same.
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
  double offset_N_ = 0;
  bool distrusted_ = false;
  double peak_force_N_ = 0;
  std::optional<double> last_force_N_, last_travel_m_;
  double noise_N_ = 0;  // of a sample, where the return began
  std::optional<double> stood_m_;
  std::optional<double> old_zero_m_;  // until a sample shows the new one
};

}  // namespace lcrig
