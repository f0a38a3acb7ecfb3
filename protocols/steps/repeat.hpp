// SPDX-License-Identifier: Apache-2.0
// The step `repeat`: runs its steps several times.
#pragma once

#include "protocols/steps/facts.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

struct RepeatStep {
  static constexpr std::string_view kWord = "repeat";
  Number count;
  Steps steps;

  using Progress = RemembersNothing;
  static RepeatStep parse(const StepReader& r);
  StepFacts facts() const {
    return {FrameUse::none(), kNoReadings, kNoSettings, kNoQuestion, Loop(*this)};
  }
  std::int64_t passes(const Environment& env) const;
  const Number* repeats() const { return &count; }
  const std::string* variable() const { return nullptr; }
  std::vector<const Number*> ends() const { return {}; }
  void set_variable(std::int64_t /*pass*/, Environment& /*env*/) const {}
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, Progress& progress) const;
};

}  // namespace lcrig
