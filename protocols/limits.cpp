// SPDX-License-Identifier: Apache-2.0
#include "protocols/limits.hpp"

namespace lcrig {

Result<BoundLimits> bind_limits(const Protocol& protocol, const Environment& env) {
  const Limits& l = protocol.limits;
  BoundLimits out;
  out.force_min_N = env.get(l.force_min);
  out.force_max_N = env.get(l.force_max);
  if (l.travel_min) out.travel_min_m = env.get(*l.travel_min);
  if (l.travel_max) out.travel_max_m = env.get(*l.travel_max);
  if (l.speed_max) out.speed_max_m_s = env.get(*l.speed_max);
  if (out.force_min_N >= out.force_max_N) {
    return fail(Errc::invalid_request,
                "{} /limits: force from {:.6g} to {:.6g} N, expected the lower limit first",
                protocol.name, out.force_min_N, out.force_max_N);
  }
  if (out.travel_min_m && *out.travel_min_m >= *out.travel_max_m) {
    return fail(Errc::invalid_request,
                "{} /limits: travel from {:.6g} to {:.6g} mm, expected the lower limit first",
                protocol.name, *out.travel_min_m * 1e3, *out.travel_max_m * 1e3);
  }
  return out;
}

FrameLimits device_limits(const BoundLimits& limits, const FrameCapabilities& caps) {
  FrameLimits out;
  out.force_min = Force::from_si(limits.force_min_N);
  out.force_max = Force::from_si(limits.force_max_N);
  out.travel_min = Length::from_si(limits.travel_min_m.value_or(caps.travel_min.si()));
  out.travel_max = Length::from_si(limits.travel_max_m.value_or(caps.travel_max.si()));
  out.speed_max = Velocity::from_si(limits.speed_max_m_s.value_or(caps.speed_max.si()));
  return out;
}

}  // namespace lcrig
