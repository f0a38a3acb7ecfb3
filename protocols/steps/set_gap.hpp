// SPDX-License-Identifier: Apache-2.0
// The step `set_gap`: a person states the distance between probe and specimen, so no search is
// needed.
#pragma once

#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct SetGapStep final : StepOf<SetGapStep> {
  static constexpr std::string_view kWord = "set_gap";
  Number gap;  // m, at the present travel

  using Progress = RemembersNothing;
  static SetGapStep parse(const StepReader& r);
  StepFacts facts() const override {
    return {FrameUse::none(), kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const override;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override;
};

}  // namespace lcrig
