// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "protocols/checks/checks.hpp"

namespace lcrig::checks {

// No real cell repeats its last digit for ever.
Found frozen_digits(const RigState& rig, const Sight& sight) {
  const auto most = rig.tolerances.frozen_samples;
  if (!sight.sample.force_N || !rig.trust.force || !most) return std::nullopt;
  if (rig.course.equal_forces <= *most) return std::nullopt;
  return fmt::format(
      "the load cell is frozen: {:.6g} N in {} samples one after another, and its last digit "
      "changed all the time before",
      *sight.sample.force_N, rig.course.equal_forces);
}

}  // namespace lcrig::checks
