// SPDX-License-Identifier: Apache-2.0
// The step `ramp`: moves to a target at a speed, or lets the frame's force loop follow a rate.
#pragma once

#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct RampStep final : StepOf<RampStep> {
  static constexpr std::string_view kWord = "ramp";
  Target to;
  std::optional<Number> speed;  // m/s
  std::optional<Number> force_rate;  // N/s, for force and pressure targets
  Number timeout;  // s

  struct Progress : StepProgress {
    TimeSpent time;
    // End of the way back without contact. Chosen once, even if the frame is lost several times.
    std::optional<double> away_m;
    void go_on_from(const LeftOff& /*before*/) override {}
    void interrupt(MonoTime now) override { time.end(now); }
    void begin_again(RunParts& /*run*/) override { time.forget(); }
  };
  static RampStep parse(const StepReader& r);
  StepFacts facts() const override {
    const HoldMode leaves = speed ? HoldMode::travel : HoldMode::force;
    return {FrameUse::motion(&to, speed ? &*speed : nullptr, leaves), kNoReadings, kNoSettings,
            kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const override;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override;
};

}  // namespace lcrig
