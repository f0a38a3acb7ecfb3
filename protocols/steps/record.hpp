// SPDX-License-Identifier: Apache-2.0
// The step `record`: only records, for a time or until a person confirms.
#pragma once

#include "protocols/steps/facts.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

struct RecordStep {
  static constexpr std::string_view kWord = "record";
  std::optional<Number> duration;  // s
  bool until_confirmed = false;
  Number timeout;  // s, with until_confirmed

  using Progress = RemembersTime;
  static RecordStep parse(const StepReader& r);
  StepFacts facts() const {
    return {FrameUse::none(), kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, Progress& progress) const;
};

}  // namespace lcrig
