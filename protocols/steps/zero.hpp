// SPDX-License-Identifier: Apache-2.0
// The step `zero`: sets the zero of force, travel or both to what the frame shows now.
#pragma once

#include "protocols/steps/facts.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

struct ZeroStep {
  static constexpr std::string_view kWord = "zero";
  bool force = false, travel = false;
  std::optional<Number> max_offset;  // N; a larger offset means that the probe touches already

  using Progress = RemembersNothing;
  static ZeroStep parse(const StepReader& r);
  StepFacts facts() const {
    return {FrameUse::zero(), kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, Progress& progress) const;
};

}  // namespace lcrig
