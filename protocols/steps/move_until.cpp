// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/move_until.hpp"

#include "protocols/file/step_reader.hpp"

namespace lcrig {

MoveUntilStep MoveUntilStep::parse(const StepReader& r) {
  MoveUntilStep out;
  out.until = r.target("until");
  out.speed = r.required("speed", Dimension::speed, kSpeeds);
  out.final_speed = r.optional("final_speed", Dimension::speed, kSpeeds);
  if (const auto fraction = r.json.find("final_from")) {
    out.final_from = r.scope.read(*fraction, Dimension::none, 1, Range{0, 1, true});
  }
  out.overshoot = r.optional("overshoot", Dimension::force, kPositiveForces);
  out.timeout = r.timeout();
  if (out.final_speed.has_value() != out.final_from.has_value()) {
    r.json.refuse("one of final_speed and final_from, expected both or none");
  }
  if (!is_force(out.until) && (out.final_speed || out.overshoot)) {
    r.json.refuse("final_speed or overshoot without a force, expected until force or pressure");
  }
  return out;
}

StepFacts MoveUntilStep::facts() const {
  return {.moves = true,
          .loads_a_cycle = is_force(until),
          .aim = &until,
          .speed = &speed,
          .leaves = HoldMode::travel};
}

}  // namespace lcrig
