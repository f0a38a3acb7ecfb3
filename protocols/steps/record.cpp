// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/record.hpp"

#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"

namespace lcrig {

RecordStep RecordStep::parse(const StepReader& r) {
  RecordStep out;
  out.duration = r.optional("for", Dimension::time, kTimes);
  if (const auto until = r.json.find("until")) {
    static constexpr std::pair<std::string_view, bool> kUntil[] = {{"confirmed", true}};
    out.until_confirmed = until->word<bool>(kUntil);
    out.timeout = r.timeout();
  }
  if (out.duration.has_value() == out.until_confirmed) {
    r.json.refuse("expected exactly one of for_s (or another unit) and \"until\": \"confirmed\"");
  }
  return out;
}

StepPlan RecordStep::plan(PlannedRig& rig) const {
  StepPlan out(rig.get(until_confirmed ? timeout : *duration));
  if (until_confirmed) out.note = "until confirmed, at most this long";
  return out;
}

}  // namespace lcrig
