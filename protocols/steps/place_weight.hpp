// SPDX-License-Identifier: Apache-2.0
// The step `place_weight`: a person places a mass on the rod and confirms.
#pragma once

#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct PlaceWeightStep final : StepOf<PlaceWeightStep> {
  static constexpr std::string_view kWord = "place_weight";
  Target load;  // a mass, or the force or pressure that it has to produce

  using Progress = RemembersNothing;
  static PlaceWeightStep parse(const StepReader& r);
  StepFacts facts() const override {
    return {FrameUse::weight(load), kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const override;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override;
};

}  // namespace lcrig
