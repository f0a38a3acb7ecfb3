// SPDX-License-Identifier: Apache-2.0
// repeat: runs its steps several times.
#pragma once

#include "protocols/steps/facts.hpp"

namespace lcrig {

struct RepeatStep {
  static constexpr std::string_view kWord = "repeat";
  Number count;
  Steps steps;

  static RepeatStep parse(const StepReader& r);
  StepFacts facts() const {
    return {FrameUse::none(), kNoReadings, kNoSettings, kNoQuestion, Loop(steps, count)};
  }
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, StepProgress& progress) const;
};

}  // namespace lcrig
