// SPDX-License-Identifier: Apache-2.0
// The step `set_gap`: a person states the distance between probe and specimen, so no search is
// needed.
#pragma once

#include "protocols/steps/facts.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

struct SetGapStep {
  static constexpr std::string_view kWord = "set_gap";
  Number gap;  // m, at the present travel

  using Progress = RemembersNothing;
  static SetGapStep parse(const StepReader& r);
  StepFacts facts() const {
    return {FrameUse::none(), kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, Progress& progress) const;
};

}  // namespace lcrig
