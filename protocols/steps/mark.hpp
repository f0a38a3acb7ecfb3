// SPDX-License-Identifier: Apache-2.0
// mark: writes a text of the file into the record.
#pragma once

#include "protocols/steps/facts.hpp"

namespace lcrig {

struct MarkStep {
  static constexpr std::string_view kWord = "mark";
  std::string text;

  static MarkStep parse(const StepReader& r);
  StepFacts facts() const {
    return {FrameUse::none(), kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, StepProgress& progress) const;
};

}  // namespace lcrig
