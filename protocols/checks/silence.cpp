// SPDX-License-Identifier: Apache-2.0
// Samples that do not come, or come without what the limits need.
#include <fmt/format.h>

#include "protocols/checks/checks.hpp"

namespace lcrig::checks {

Found no_travel(const RigState& rig, const Sight& sight) {
  if (!rig.watches_age || !rig.course.travel_at) return std::nullopt;
  const Duration age = sight.sample.received - *rig.course.travel_at;
  if (age <= kTwice.count() * stale_after(rig.facts.rate_Hz)) return std::nullopt;
  return fmt::format("no travel in the samples for {:.2f} s", to_seconds(age));
}

Found no_force(const RigState& rig, MonoTime now) {
  const Duration stale = stale_after(rig.facts.rate_Hz);
  const auto& force_at = rig.course.force_at;
  if (!force_at || now - *force_at <= stale) return std::nullopt;
  // On the retreat the travel alone is enough.
  const auto& travel_at = rig.course.travel_at;
  if (rig.phase == RunPhase::finally && travel_at && now - *travel_at <= stale) return std::nullopt;
  return fmt::format("no force sample for {:.2f} s", to_seconds(now - *force_at));
}

}  // namespace lcrig::checks
