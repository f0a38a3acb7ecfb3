// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/step.hpp"

#include "base/clock.hpp"
#include "protocols/plan/planned_rig.hpp"

namespace lcrig {

StepFacts Loop::facts() const {
  return {FrameUse::none(), kNoReadings, kNoSettings, kNoQuestion, this};
}

StepPlan Loop::plan(PlannedRig& /*rig*/) const {
  return {};
}

Task<Result<>> Loop::execute(RunParts& /*run*/, StepProgress& /*remembered*/) const {
  co_return fail(Errc::bug, "a loop reached the run");
}

}  // namespace lcrig
