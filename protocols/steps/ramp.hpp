// SPDX-License-Identifier: Apache-2.0
// ramp: moves to a target at a speed, or lets the force loop of the frame follow a rate.
#pragma once

#include "protocols/steps/facts.hpp"

namespace lcrig {

struct RampStep {
  static constexpr std::string_view kWord = "ramp";
  Target to;
  std::optional<Number> speed;  // m/s
  std::optional<Number> force_rate;  // N/s, for force and pressure targets
  Number timeout;  // s

  static RampStep parse(const StepReader& r);
  StepFacts facts() const {
    const HoldMode leaves = speed ? HoldMode::travel : HoldMode::force;
    return {FrameUse::motion(&to, speed ? &*speed : nullptr, leaves, FrameUse::OnTheWay::nothing),
            kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, StepProgress& progress) const;
};

}  // namespace lcrig
