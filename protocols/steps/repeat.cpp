// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/repeat.hpp"

#include <cmath>

#include "protocols/file/step_reader.hpp"

namespace lcrig {

RepeatStep RepeatStep::parse(const StepReader& r) {
  RepeatStep out;
  out.count = r.count("count", 1, kCountMax);
  out.steps = r.steps();
  return out;
}

std::int64_t RepeatStep::passes(const Environment& env) const {
  return std::llround(env.get(count));
}

}  // namespace lcrig
