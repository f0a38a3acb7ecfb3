// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/ramp.hpp"

#include "protocols/file/step_reader.hpp"

namespace lcrig {

RampStep RampStep::parse(const StepReader& r) {
  RampStep out;
  out.to = r.target("to");
  out.speed = r.optional("speed", Dimension::speed, kSpeeds);
  out.force_rate = r.optional("force_rate", Dimension::force_rate, kPositive);
  out.timeout = r.timeout();
  if (!is_force(out.to) && !out.speed) {
    r.json.refuse("no speed, expected speed_mm_s (or another unit) for a ramp to a travel or gap");
  }
  if (!is_force(out.to) && out.force_rate) {
    r.json.refuse("a force rate, expected a force or pressure to ramp to");
  }
  if (out.speed.has_value() == out.force_rate.has_value()) {
    r.json.refuse("expected exactly one of speed_mm_s and force_rate_N_s (or another unit)");
  }
  return out;
}

StepFacts RampStep::facts() const {
  return {.moves = true,
          .aim = &to,
          .speed = speed ? &*speed : nullptr,
          .leaves = speed ? HoldMode::travel : HoldMode::force};
}

}  // namespace lcrig
