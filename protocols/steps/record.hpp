// SPDX-License-Identifier: Apache-2.0
// The step `record`: only records, for a time or until a person confirms.
#pragma once

#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct RecordStep final : StepOf<RecordStep> {
  static constexpr std::string_view kWord = "record";
  std::optional<Number> duration;  // s
  bool until_confirmed = false;
  Number timeout;  // s, with until_confirmed

  using Progress = RemembersTime;
  static RecordStep parse(const StepReader& r);
  StepFacts facts() const override {
    return {FrameUse::none(), kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const override;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override;
};

}  // namespace lcrig
