// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/mark.hpp"

#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

MarkStep MarkStep::parse(const StepReader& r) {
  MarkStep out;
  out.text = r.json.at("text").nonempty_string(1000);
  return out;
}

StepPlan MarkStep::plan(PlannedRig& /*rig*/) const {
  return {};
}

Task<Result<>> MarkStep::execute(RunParts& run, StepProgress& /*remembered*/) const {
  run.event(EventKind::mark, text);
  co_return Result<>();
}

}  // namespace lcrig
