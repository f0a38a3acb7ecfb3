// SPDX-License-Identifier: Apache-2.0
// The limits of a protocol, checked on every sample in parallel with every step. Pure logic: the
// run feeds it and stops the frame when it answers.
#pragma once

#include <optional>
#include <string>

#include "base/clock.hpp"
#include "drivers/load_frame.hpp"
#include "protocols/limits.hpp"

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

  // `finally` starts outside the window when a limit tripped: leaving it is allowed, going further
  // (by more than a tenth of the window) is not.
  void allow_return();
  // A passive protocol or a rod with weights has nothing that could go stale.
  void set_watch_age(bool on) { watch_age_ = on; }
  void restart_age(MonoTime now) { last_ = now; }
  double peak_force_N() const { return peak_force_N_; }

 private:
  std::optional<std::string> check_force(double force_N);
  std::optional<std::string> check_travel(double travel_m);

  BoundLimits limits_;
  Duration stale_after_;
  std::optional<MonoTime> last_;
  bool watch_age_ = false;
  bool returning_ = false;
  double peak_force_N_ = 0;
};

}  // namespace lcrig
