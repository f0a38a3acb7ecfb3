// SPDX-License-Identifier: Apache-2.0
// The step `find_contact`: moves towards the specimen until the force rises, and then backs off.
#pragma once

#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

class Forecast;

struct FindContactStep final : StepOf<FindContactStep> {
  static constexpr std::string_view kWord = "find_contact";
  Number speed, force, back_off, timeout;  // m/s, N (rise above the force at rest), m, s
  std::optional<Number> within;  // m, longest way of the search; absent: up to the limits
  std::optional<Number> overshoot;  // N allowed beyond the rise; plan and run refuse a larger one
  bool slow_down = false;  // `speed` is the highest speed: lower where this rig would stop too late

  struct Progress : StepProgress {
    std::optional<double> start_travel_m;  // start of the search, kept when it begins again
    void go_on_from(const LeftOff& before) override { start_travel_m = before.start_travel_m; }
    void interrupt(MonoTime /*now*/) override {}
    void begin_again(RunParts& /*run*/) override {}
  };
  static FindContactStep parse(const StepReader& r);
  StepFacts facts() const override {
    return {FrameUse::motion(nullptr, &speed, HoldMode::travel), kNoReadings, kNoSettings,
            kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const override;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override;
  // The speed of the search: that of the file; with slow_down at most so fast that the stop needs
  // half of the room between threshold and limit.
  double search_speed_m_s(const Environment& env, const Forecast& forecast, double room_N,
                          double slowest_m_s) const;
};

}  // namespace lcrig
