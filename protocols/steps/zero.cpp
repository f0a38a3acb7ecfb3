// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/zero.hpp"

#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"

namespace lcrig {

ZeroStep ZeroStep::parse(const StepReader& r) {
  ZeroStep out;
  out.force = r.json.optional_boolean("force").value_or(false);
  out.travel = r.json.optional_boolean("travel").value_or(false);
  out.max_offset = r.optional("max_offset", Dimension::force, kPositiveForces);
  if (!out.force && !out.travel) {
    r.json.refuse("nothing to zero, expected \"force\": true or \"travel\": true or both");
  }
  if (out.max_offset && !out.force) {
    r.json.refuse("max_offset without \"force\": true, expected both or none");
  }
  return out;
}

StepPlan ZeroStep::plan(PlannedRig& rig) const {
  StepPlan out(1);
  const FrameCapabilities& caps = rig.frame();
  if (force && !caps.zero_force) {
    out.refuse(Refusal("zero of the force, which this rig cannot do"));
  } else if (travel && !caps.zero_travel) {
    out.refuse(Refusal("zero of the travel, which this rig cannot do"));
  }
  if (travel) rig.zero_travel();
  if (force) rig.zero_force();
  return out;
}

}  // namespace lcrig
