// SPDX-License-Identifier: Apache-2.0
// A force below the lower limit. A specimen that pulls is left to a person; a cell that shows what
// no specimen can do is not valid.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "protocols/checks/checks.hpp"

namespace lcrig::checks {

namespace {

bool is_below(const RigState& rig, const FrameSample& sample) {
  return sample.force_N && *sample.force_N < rig.limits.force_min_N;
}

// The last two forces differ only in their sign, and a contact of this stiffness does not explain
// that by the way between them. Any other fall may come from a specimen that pulls.
bool has_changed_sign(const RigState& rig, double stiffness_N_m) {
  const auto& before = rig.course.place_before;
  const auto& now = rig.course.place;
  if (!rig.trust.force || !before || !now || !now->travel_m || !before->travel_m) return false;
  const double way_m = std::abs(*now->travel_m - *before->travel_m) + rig.travel_tolerance_m();
  const double by_way_N = stiffness_N_m * way_m + 2 * rig.tolerances.contact_force_N;
  const double before_N = before->force_N - rig.frame.order.zero_N;
  const double now_N = now->force_N - rig.frame.order.zero_N;
  return before_N - now_N > by_way_N && std::abs(before_N + now_N) < by_way_N;
}

}  // namespace

Found sign_changed(const RigState& rig, const Sight& sight) {
  if (!is_below(rig, sight.sample)) return std::nullopt;
  const double felt_N = std::max(rig.course.peak_force_N, rig.force_max_N());
  if (!has_changed_sign(rig, rig.forecast->bound().stiffness_N_m(felt_N))) return std::nullopt;
  return fmt::format(
      "the force falls to {:.4f} N at once, which is what it was with the other sign: the load "
      "cell is connected the wrong way",
      *sight.sample.force_N);
}

Found pulls_without_retreat(const RigState& rig, const Sight& sight) {
  if (!is_below(rig, sight.sample) || rig.may_pull()) return std::nullopt;
  return fmt::format(
      "the force falls to {:.4f} N though the frame does not move away from the specimen, which "
      "can only pull then: the load cell is connected the wrong way, or lost its zero",
      *sight.sample.force_N);
}

}  // namespace lcrig::checks
