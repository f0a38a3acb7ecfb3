// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/limits.hpp"

#include <algorithm>
#include <cmath>

#include "protocols/rig/rest_measurement.hpp"

namespace lcrig {

namespace {

constexpr double kUnbounded_N = 1e9;  // no tolerance
constexpr double kRounding = 1e-9;  // no tolerance: relative

tl::unexpected<Error> wrong_way(const Protocol& protocol, std::string_view what, double low,
                                double high, std::string_view unit) {
  return fail(Errc::invalid_request,
              "{} /limits: {} from {:.6g} to {:.6g} {}, expected the lower limit first",
              protocol.name, what, low, high, unit);
}

}  // namespace

bool exceeds(double v, double max) {
  return v > max + kRounding * std::max(std::abs(max), 1e-6);
}

double least_trip_N(const FrameCapabilities& caps, double noise_N) {
  return std::max(caps.cell().zero_error_N(caps.force_max.si()), 6 * noise_N);
}

double largest_end_N(double limit_N, double noise_N) {
  return limit_N - kSampleSigmas * noise_N;
}

void BoundLimits::place_contact(double contact_travel_m) {
  if (!gap_min_m) return;
  const double deepest = contact_travel_m - *gap_min_m, highest = contact_travel_m - *gap_max_m;
  travel_max_m = travel_max_m ? std::min(*travel_max_m, deepest) : deepest;
  travel_min_m = travel_min_m ? std::max(*travel_min_m, highest) : highest;
}

void BoundLimits::zero_travel(double travel_m) {
  if (!travel_min_m) return;
  *travel_min_m -= travel_m;
  *travel_max_m -= travel_m;
}

FrameCapabilities with_zero_at(FrameCapabilities caps, double travel_m) {
  caps.travel_min = Length::from_si(caps.travel_min.si() - travel_m);
  caps.travel_max = Length::from_si(caps.travel_max.si() - travel_m);
  return caps;
}

Result<BoundLimits> bind_limits(const Protocol& protocol, const Environment& env,
                                const FrameCapabilities& caps) {
  const Limits& l = protocol.limits;
  const auto get = [&env](const std::optional<Number>& n) {
    return n ? std::optional(env.get(*n)) : std::nullopt;
  };
  // A cell without a stated range (in a recording) has none.
  const double cell_N = caps.force_max.si() > 0 ? caps.force_max.si() : kUnbounded_N;
  BoundLimits out;
  out.force_min_N = get(l.force_min).value_or(-cell_N);
  out.force_max_N = get(l.force_max).value_or(cell_N);
  out.travel_min_m = get(l.travel_min);
  out.travel_max_m = get(l.travel_max);
  out.gap_min_m = get(l.gap_min);
  out.gap_max_m = get(l.gap_max);
  out.speed_max_m_s = get(l.speed_max);
  if (l.force_min && out.force_min_N >= out.force_max_N) {
    return wrong_way(protocol, "force", out.force_min_N, out.force_max_N, "N");
  }
  if (out.travel_min_m && *out.travel_min_m >= *out.travel_max_m) {
    return wrong_way(protocol, "travel", *out.travel_min_m * 1e3, *out.travel_max_m * 1e3, "mm");
  }
  if (out.gap_min_m && *out.gap_min_m >= *out.gap_max_m) {
    return wrong_way(protocol, "gap", *out.gap_min_m * 1e3, *out.gap_max_m * 1e3, "mm");
  }
  return out;
}

FrameLimits device_limits(const BoundLimits& limits, const FrameCapabilities& caps) {
  const Length low = caps.travel_min, high = caps.travel_max;
  FrameLimits out;
  out.force_min = Force::from_si(limits.force_min_N);
  out.force_max = Force::from_si(limits.force_max_N);
  out.travel_min = std::max(low, Length::from_si(limits.travel_min_m.value_or(low.si())));
  out.travel_max = std::min(high, Length::from_si(limits.travel_max_m.value_or(high.si())));
  out.speed_max = std::min(caps.speed_max,
                           Velocity::from_si(limits.speed_max_m_s.value_or(caps.speed_max.si())));
  return out;
}

}  // namespace lcrig
