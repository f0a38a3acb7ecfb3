// SPDX-License-Identifier: Apache-2.0
// The step `zero`: sets the zero of force, travel or both to what the frame shows now.
#pragma once

#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct ZeroStep final : StepOf<ZeroStep> {
  static constexpr std::string_view kWord = "zero";
  bool force = false, travel = false;
  std::optional<Number> max_offset;  // N; a larger offset means that the probe touches already

  using Progress = RemembersNothing;
  static ZeroStep parse(const StepReader& r);
  StepFacts facts() const override {
    return {FrameUse::zero(), kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const override;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override;
};

}  // namespace lcrig
