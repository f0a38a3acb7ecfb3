// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/repeat.hpp"

#include <cmath>

#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

RepeatStep RepeatStep::parse(const StepReader& r) {
  return {.count = r.count("count", 1, kCountMax), .steps = r.steps()};
}

std::int64_t RepeatStep::passes(const Environment& env) const {
  return std::llround(env.get(count));
}

// The planner visits the inner steps itself, one by one.
StepPlan RepeatStep::plan(PlannedRig& /*rig*/) const {
  return {};
}

Task<Result<>> RepeatStep::execute(RunParts& /*run*/, Progress& /*progress*/) const {
  co_return fail(Errc::bug, "a loop reached the run");
}

}  // namespace lcrig
