// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/record.hpp"

#include "protocols/file/step_reader.hpp"

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

StepFacts RecordStep::facts() const {
  return {};
}

}  // namespace lcrig
