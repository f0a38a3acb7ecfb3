// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/repeat.hpp"

#include "protocols/file/step_reader.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

RepeatStep RepeatStep::parse(const StepReader& r) {
  RepeatStep out;
  out.count = r.count("count", 1, kCountMax);
  out.steps = r.steps();
  return out;
}

StepFacts RepeatStep::facts() const {
  return {.inside = &steps, .passes = &count};
}

}  // namespace lcrig
