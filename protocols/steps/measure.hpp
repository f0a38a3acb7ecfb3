// SPDX-License-Identifier: Apache-2.0
// measure: takes fresh readings of the meter within a time; they make one level.
#pragma once

#include "protocols/steps/facts.hpp"

namespace lcrig {

struct MeasureStep {
  static constexpr std::string_view kWord = "measure";
  Number count;  // fresh readings
  Number within;  // s

  static MeasureStep parse(const StepReader& r);
  StepFacts facts() const { return {FrameUse::none(), this, kNoSettings, kNoQuestion, kNoLoop}; }
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, StepProgress& progress) const;
};

}  // namespace lcrig
