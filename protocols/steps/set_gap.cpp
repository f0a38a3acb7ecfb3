// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/set_gap.hpp"

#include <fmt/format.h>

#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"

namespace lcrig {

SetGapStep SetGapStep::parse(const StepReader& r) {
  return {r.required("gap", Dimension::length, Range{0, 1})};
}

StepPlan SetGapStep::plan(PlannedRig& rig) const {
  StepPlan out;
  rig.state_gap(rig.get(gap));
  out.note = fmt::format("a gap of {:.4g} mm, as the protocol says", rig.get(gap) * 1e3);
  return out;
}

}  // namespace lcrig
