// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/set_gap.hpp"

#include "protocols/file/step_reader.hpp"

namespace lcrig {

SetGapStep SetGapStep::parse(const StepReader& r) {
  return {r.required("gap", Dimension::length, Range{0, 1})};
}

StepFacts SetGapStep::facts() const {
  return {};
}

}  // namespace lcrig
