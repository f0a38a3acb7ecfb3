// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/set_gap.hpp"

#include <fmt/format.h>

#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

SetGapStep SetGapStep::parse(const StepReader& r) {
  SetGapStep out;
  out.gap = r.required("gap", Dimension::length, Range{0, 1});
  return out;
}

StepPlan SetGapStep::plan(PlannedRig& rig) const {
  StepPlan out;
  rig.state_gap(rig.get(gap));
  out.note = fmt::format("a gap of {:.4g} mm, as the protocol says", rig.get(gap) * 1e3);
  return out;
}

// Places contact by a person's statement instead of a search.
Task<Result<>> SetGapStep::execute(RunParts& run, StepProgress& /*remembered*/) const {
  if (!run.rig.frame.seen.travel_m) {
    co_return fail(Errc::no_reply, "step {}: the frame sends no travel", run.log.step_id());
  }
  const double contact_m = *run.rig.frame.seen.travel_m + run.get(gap);
  run.watch.place_contact(contact_m, 0);
  run.event(GapStatedEvent{contact_m});
  co_return Result<>();
}

}  // namespace lcrig
