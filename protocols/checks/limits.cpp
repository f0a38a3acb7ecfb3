// SPDX-License-Identifier: Apache-2.0
// The limits of the protocol, during the steps and on the retreat of `finally`.
#include <fmt/format.h>

#include <algorithm>

#include "protocols/checks/checks.hpp"

namespace lcrig::checks {

namespace {

constexpr double kUnbounded_m = 1e9;  // no tolerance

Found travel_outside(const RigState& rig, const FrameSample& sample, double low_m, double high_m) {
  // Samples with the old zero may still arrive.
  if (!sample.travel_m || rig.course.old_zero_m) return std::nullopt;
  if (*sample.travel_m >= low_m && *sample.travel_m <= high_m) return std::nullopt;
  return fmt::format("travel {:.4f} mm is outside the limits {:.4f} to {:.4f} mm",
                     *sample.travel_m * 1e3, rig.limits.travel_min_m.value_or(-kUnbounded_m) * 1e3,
                     rig.limits.travel_max_m.value_or(kUnbounded_m) * 1e3);
}

// On a retreat: the force counts as unknown, and only less travel is certain to unload.
bool is_blind(const RigState& rig, const FrameSample& sample) {
  const bool silent = !sample.force_N && rig.course.force_at &&
                      sample.received - *rig.course.force_at > stale_after(rig.facts.rate_Hz);
  return rig.frame.overloaded || !rig.trust.force || silent;
}

}  // namespace

Found beyond_cell(const RigState& rig, const Sight& /*sight*/) {
  if (!rig.frame.overloaded) return std::nullopt;
  return "the force is beyond the load cell";
}

Found force_limit(const RigState& rig, const Sight& sight) {
  const auto& force_N = sight.sample.force_N;
  if (!force_N || (*force_N >= rig.limits.force_min_N && *force_N <= rig.force_max_N())) {
    return std::nullopt;
  }
  return fmt::format("force {:.4f} N is outside the limits {:.4f} to {:.4f} N", *force_N,
                     rig.limits.force_min_N, rig.force_max_N());
}

Found travel_limit(const RigState& rig, const Sight& sight) {
  return travel_outside(rig, sight.sample, rig.limits.travel_min_m.value_or(-kUnbounded_m),
                        rig.limits.travel_max_m.value_or(kUnbounded_m));
}

// Forces up to the largest one of the run are allowed, as long as they do not rise.
Found force_on_retreat(const RigState& rig, const Sight& sight) {
  const auto& force_N = sight.sample.force_N;
  if (!force_N || is_blind(rig, sight.sample)) return std::nullopt;
  const double peak_N = rig.course.peak_force_N;
  const double most_N = std::max(rig.force_max_N(), (1 + rig.facts.cell.part()) * peak_N +
                                                        kSampleSigmas * rig.course.retreat_noise_N);
  if (*force_N > most_N) {
    return fmt::format("force {:.4f} N rises on the way back, which began at {:.4f} N", *force_N,
                       peak_N);
  }
  return *force_N < rig.limits.force_min_N ? force_limit(rig, sight) : std::nullopt;
}

// Travels between the start of the retreat and the limits are allowed.
Found travel_on_retreat(const RigState& rig, const Sight& sight) {
  if (is_blind(rig, sight.sample)) return std::nullopt;
  double low_m = rig.limits.travel_min_m.value_or(-kUnbounded_m);
  double high_m = rig.limits.travel_max_m.value_or(kUnbounded_m);
  if (const auto& from_m = rig.course.retreat_from_m) {
    low_m = std::min(low_m, *from_m - kStanding_m);
    high_m = std::max(high_m, *from_m + kStanding_m);
  }
  return travel_outside(rig, sight.sample, low_m, high_m);
}

// Without a valid force, only motion away from the specimen is certain to unload it.
Found blind_retreat(const RigState& rig, const Sight& sight) {
  const auto& travel_m = sight.sample.travel_m;
  const auto& from_m = rig.course.retreat_from_m;
  const bool away = travel_m && from_m && *travel_m <= *from_m + kStanding_m;
  if (!is_blind(rig, sight.sample) || away) return std::nullopt;
  return "the load cell shows no force that counts, and the frame does not move away from the "
         "specimen";
}

}  // namespace lcrig::checks
