// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/find_contact.hpp"

#include "protocols/file/step_reader.hpp"

namespace lcrig {

namespace {
constexpr Range kBackOff{0, 1};  // m
constexpr Range kWays{0, 10, true};
}  // namespace

FindContactStep FindContactStep::parse(const StepReader& r) {
  FindContactStep out;
  out.speed = r.required("speed", Dimension::speed, kSpeeds);
  out.force = r.required("force", Dimension::force, kPositiveForces);
  out.back_off = r.required("back_off", Dimension::length, kBackOff);
  out.timeout = r.timeout();
  out.within = r.optional("within", Dimension::length, kWays);
  out.overshoot = r.optional("overshoot", Dimension::force, kPositiveForces);
  out.slow_down = r.json.optional_boolean("slow_down").value_or(false);
  return out;
}

StepFacts FindContactStep::facts() const {
  return {.moves = true, .speed = &speed, .leaves = HoldMode::travel};
}

}  // namespace lcrig
