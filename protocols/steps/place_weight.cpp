// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/place_weight.hpp"

#include <fmt/format.h>

#include "protocols/file/step_reader.hpp"

namespace lcrig {

PlaceWeightStep PlaceWeightStep::parse(const StepReader& r) {
  PlaceWeightStep out;
  const auto mass = r.optional("mass", Dimension::mass, Range{0, 1e5});  // kg
  int given = mass ? 1 : 0;
  const auto load = r.load(Range{0, kForces.max}, given);
  if (given != 1) {
    r.json.refuse(
        fmt::format("{} loads, expected exactly one of mass_g, force_N, pressure_kPa (or "
                    "another unit)",
                    given));
  }
  if (load) {
    out.load = *load;
  } else if (mass) {
    out.load.kind = TargetKind::mass;
    out.load.value = *mass;
  }
  return out;
}

StepFacts PlaceWeightStep::facts() const {
  return {.places_weight = true, .aim = &load};
}

}  // namespace lcrig
