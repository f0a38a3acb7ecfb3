// SPDX-License-Identifier: Apache-2.0
// Ends a run, whatever happened before: stops the frame, runs `finally`, makes the meter safe, and
// reports truthfully whether the specimen is still loaded. Used by `Run`.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "protocols/run/interrupts.hpp"
#include "protocols/run/setup.hpp"

namespace lcrig {

class Losses;
class RestMeasurement;
class TakeOver;
struct RunParts;

class Finish {
 public:
  // Runs the steps of `finally`. Returns the request that stopped them, if one did.
  using RunSteps = std::function<Task<std::optional<InterruptRequest>>()>;
  Finish(RunParts& run, Losses& losses, const TakeOver& take_over, RunSteps run_steps)
      : run_(run), losses_(losses), take_over_(take_over), run_steps_(std::move(run_steps)) {}

  // `stop`: the request that ended the steps; nullopt when all of them were done.
  Task<RunResult> end(std::optional<InterruptRequest> stop);

 private:
  Task<> prove_readings(bool stopped);
  Task<> stop_for(const std::optional<InterruptRequest>& stop);
  Task<> see_standstill();
  bool may_clear(bool frozen);
  Task<> run_finally();
  void tell_standstill();
  void tell_hands_off(bool cleared);
  Task<> tell_load();
  std::string load_left(const Result<RestMeasurement>& rest) const;
  Task<> make_meter_safe();
  void fail_with(Errc code, std::string_view why);
  void hear(const InterruptRequest& stop);
  void tell_not_run(std::string_view why);

  RunParts& run_;
  Losses& losses_;
  const TakeOver& take_over_;
  RunSteps run_steps_;
  RunResult result_;
  std::optional<Error> unproven_;  // readings of the steps are, and the protocol does not allow it
  // What the run's reason contains already.
  bool told_hands_off_ = false, told_not_run_ = false, told_standstill_ = false;
};

}  // namespace lcrig
