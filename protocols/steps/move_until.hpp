// SPDX-License-Identifier: Apache-2.0
// The step `move_until`: moves until a target is reached, towards the specimen or away from it.
#pragma once

#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct MoveUntilStep final : StepOf<MoveUntilStep> {
  static constexpr std::string_view kWord = "move_until";
  Target until;
  Number speed;  // m/s
  std::optional<Number> final_speed;  // m/s, for an approach at two speeds
  std::optional<Number> final_from;  // the final speed begins at this fraction of the target force
                                     // (0..1)
  std::optional<Number> overshoot;  // N allowed beyond the target; plan and run refuse a larger one
  Number timeout;  // s

  using Progress = RemembersTime;
  static MoveUntilStep parse(const StepReader& r);
  StepFacts facts() const override {
    return {is_force(until) ? FrameUse::cycle(until, speed, HoldMode::travel)
                            : FrameUse::motion(&until, &speed, HoldMode::travel),
            kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const override;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override;
};

}  // namespace lcrig
