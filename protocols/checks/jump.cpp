// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "protocols/checks/checks.hpp"

namespace lcrig::checks {

Found force_jumps(const RigState& rig, const Sight& /*sight*/) {
  if (!rig.course.jump || rig.course.jump->moves) return std::nullopt;
  return fmt::format(
      "the force jumped from {:.4f} N to {:.4f} N while the frame stood: the zero of the load cell "
      "was lost, or somebody touched the rig",
      rig.course.jump->before_N, rig.course.jump->after_N);
}

}  // namespace lcrig::checks
