// SPDX-License-Identifier: Apache-2.0
// hold: holds travel or force for a time.
#pragma once

#include "protocols/steps/facts.hpp"

namespace lcrig {

struct HoldStep {
  static constexpr std::string_view kWord = "hold";
  HoldMode mode = HoldMode::travel;
  std::optional<Target> at;  // force or pressure to hold; absent: where it stands
  Number duration;  // s; the mode stays in force until the next motion

  static HoldStep parse(const StepReader& r);
  StepFacts facts() const {
    return {FrameUse::hold(mode, at ? &*at : nullptr), kNoReadings, kNoSettings, kNoQuestion,
            kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, StepProgress& progress) const;
};

}  // namespace lcrig
