// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/tolerances.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "protocols/rig/cell_noise.hpp"
#include "protocols/rig/constants.hpp"

namespace lcrig {

namespace {

// The highest probability that a cell in the middle of a coarse digit repeats that digit. The digit
// itself contributes a part of the shown scatter (q/sqrt(12)).
double coarse_same(double digits) {
  const double noise = std::sqrt(std::pow(kNoiseSeen / digits, 2) - 1.0 / 12);
  return std::erf(0.5 / std::sqrt(2.0) / noise);
}

std::optional<std::int64_t> run_of_equals(const CellNoise& s) {
  if (!s.alive) return std::nullopt;
  if (s.digit_N > kCoarsestNoise * s.noise_N) return std::nullopt;
  const double p = s.digit_N > s.noise_N ? coarse_same(s.digit_N / s.noise_N)
                                         : kEqualSteps * s.digit_N / s.noise_N;
  const auto n = static_cast<std::int64_t>(std::ceil(std::log(kFrozenChance.value) / std::log(p)));
  return std::max<std::int64_t>({n, kFrozenLeast.count(), kFrozenMargin.count() * s.longest_run});
}

}  // namespace

Tolerances tolerances_of(const FrameCapabilities& caps, const ForceBound& bound, double limit_N,
                         double rate_Hz, const CellNoise* scatter, double noise_N) {
  Tolerances f;
  f.frozen_samples = scatter ? run_of_equals(*scatter) : kFrozenAssumed.count();
  if (f.frozen_samples && rate_Hz > 0) {
    f.frozen_force_s = static_cast<double>(*f.frozen_samples) / rate_Hz;
  }
  f.stall_s = kStall_s + to_seconds(caps.reaction);
  f.travel_noise_m = scatter ? scatter->travel_noise_m.value_or(0) : 0;
  const double wanders_m = 2 * kNoiseSigmas * f.travel_noise_m;
  f.against_m = kHunting_m + wanders_m;
  const double stiffness = bound.stiffness_N_m(limit_N);
  const double bearable_m = stiffness > 0 ? kStandingPart * limit_N / stiffness : kStanding_m.value;
  f.standing_m = std::clamp(bearable_m, kHunting_m.value, kStanding_m.value) + wanders_m;
  f.order_travel_m = kStanding_m + wanders_m;
  if (caps.travel_step) {
    const double step_m = kTravelSteps * caps.travel_step->si();
    for (double* allowed_m : {&f.against_m, &f.standing_m})
      *allowed_m = std::max(*allowed_m, step_m);
  }
  f.settled_s = rate_Hz > 0 ? std::max(kSilent_s.value, kSilentPeriods / rate_Hz) : kSilent_s.value;
  f.contact_force_N = kNoiseSigmas * noise_N;
  const double sure_N = scatter ? std::max(scatter->sure_noise_N(), noise_N) : noise_N;
  f.order_force_N = std::max(kDifferenceSigmas * sure_N, kOfLimit * limit_N);
  f.reply_s = kBatch_s / 2;
  return f;
}

nlohmann::json to_json(const Tolerances& f) {
  const auto maybe = [](const std::optional<double>& v) {
    return v ? nlohmann::json(*v) : nlohmann::json(nullptr);
  };
  return {{"frozen_force_s", maybe(f.frozen_force_s)},
          {"stall_s", f.stall_s},
          {"against_mm", f.against_m * 1e3},
          {"standing_mm", f.standing_m * 1e3},
          {"order_travel_mm", f.order_travel_m * 1e3},
          {"order_force_N", f.order_force_N},
          {"contact_force_N", f.contact_force_N},
          {"travel_noise_mm", f.travel_noise_m * 1e3},
          {"settled_s", f.settled_s},
          {"reply_s", f.reply_s}};
}

}  // namespace lcrig
