// SPDX-License-Identifier: Apache-2.0
// The step `mark`: records a text of the file as an event.
#pragma once

#include "protocols/steps/facts.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

struct MarkStep {
  static constexpr std::string_view kWord = "mark";
  std::string text;

  using Progress = RemembersNothing;
  static MarkStep parse(const StepReader& r);
  StepFacts facts() const {
    return {FrameUse::none(), kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, Progress& progress) const;
};

}  // namespace lcrig
