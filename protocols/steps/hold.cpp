// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/hold.hpp"

#include "protocols/file/step_reader.hpp"

namespace lcrig {

HoldStep HoldStep::parse(const StepReader& r) {
  static constexpr std::pair<std::string_view, HoldMode> kModes[] = {{"force", HoldMode::force},
                                                                     {"travel", HoldMode::travel}};
  HoldStep out;
  out.mode = r.json.word<HoldMode>("hold", kModes);
  out.duration = r.required("for", Dimension::time, Range{0, kTimes.max});
  int given = 0;
  out.at = r.load(kForces, given);
  if (given > 1) r.json.refuse("a force and a pressure, expected at most one of them");
  if (out.at && out.mode == HoldMode::travel) {
    r.json.refuse("a force beside \"hold\": \"travel\", expected \"hold\": \"force\"");
  }
  return out;
}

StepFacts HoldStep::facts() const {
  return {.aim = at ? &*at : nullptr, .leaves = mode};
}

}  // namespace lcrig
