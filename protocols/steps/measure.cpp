// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/measure.hpp"

#include "protocols/file/step_reader.hpp"

namespace lcrig {

MeasureStep MeasureStep::parse(const StepReader& r) {
  MeasureStep out;
  out.count = r.count("count", 1, kCountMax);
  out.within = r.required("within", Dimension::time, kTimes);
  return out;
}

StepFacts MeasureStep::facts() const {
  return {.measures = this};
}

}  // namespace lcrig
