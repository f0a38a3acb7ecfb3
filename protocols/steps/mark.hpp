// SPDX-License-Identifier: Apache-2.0
// The step `mark`: records a text of the file as an event.
#pragma once

#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct MarkStep final : StepOf<MarkStep> {
  static constexpr std::string_view kWord = "mark";
  std::string text;

  using Progress = RemembersNothing;
  static MarkStep parse(const StepReader& r);
  StepFacts facts() const override {
    return {FrameUse::none(), kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const override;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override;
};

}  // namespace lcrig
