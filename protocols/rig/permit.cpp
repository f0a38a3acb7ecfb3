// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/permit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lcrig {

namespace {

// As in the plan, a force within the noise counts as zero. Otherwise a speed that the plan accepted
// could be refused here.
double zero_N(const RigState& rig) {
  const double zero_N = rig.cell.zero_N();
  return std::abs(zero_N) > kNoiseSigmas * rig.cell.noise_N() ? zero_N : 0;
}

Result<> check(const RigState& rig, double worst_N, double force_N, double speed_m_s) {
  if (auto may = rig.trust.may_press(); !may) return may;
  const double most_N = rig.force_max_N();
  if (!exceeds(worst_N, most_N)) return {};
  const Forecast& forecast = *rig.forecast;
  const double fastest = forecast.fastest_m_s(force_N - zero_N(rig), most_N - zero_N(rig));
  const std::string measured = forecast.is_measured()
                                   ? "as measured at contact"
                                   : "nothing was measured at contact" + rig.contact.not_measured;
  return fail(
      Errc::invalid_request,
      "{:.4g} mm/s to {:.4g} N may end at {:.3g} N on a contact of up to {:.3g} N/mm ({}), the "
      "limit is {:.4g} N: {}",
      speed_m_s * 1e3, force_N, worst_N, forecast.bound().stiffness_N_m(worst_N) * 1e-3, measured,
      most_N,
      fastest > 0 ? fmt::format("at most {:.3g} mm/s is allowed", fastest * 1e3)
                  : std::string("state frame.stiffness_N_mm in the config"));
}

}  // namespace

Permit permit_retreat(const RigState& rig) {
  Permit permit;
  permit.limits = device_limits(rig.limits, rig.frame.caps);
  permit.limits.force_max = Force::from_si(rig.force_max_N());
  permit.guard = permit.limits.travel_max;
  permit.worst_N = rig.frame.force_N.value_or(0);
  permit.from_m = rig.frame.seen.travel_m;
  return permit;
}

// The specimen feels the force beyond zero, so the forecast counts from there.
Result<Permit> permit_to_force(const RigState& rig, double force_N, double speed_m_s) {
  Permit permit = permit_retreat(rig);
  const double felt_N = force_N - zero_N(rig);
  permit.threshold_N = force_N;
  permit.presses = true;
  permit.worst_N = zero_N(rig) + rig.forecast->stop_N(felt_N, speed_m_s);
  if (const auto expected_N = rig.forecast->expected_stop_N(felt_N, speed_m_s)) {
    permit.expected_N = zero_N(rig) + *expected_N;
  }
  auto allowed = check(rig, permit.worst_N, force_N, speed_m_s);
  if (!allowed) return fail(allowed.error());
  // Stopping at the travel limit needs its own way.
  permit.guard -= Length::from_si(stopping_way_m(rig.frame.caps, speed_m_s));
  const auto here_m = rig.frame.seen.travel_m;
  if (here_m && permit.guard.si() <= *here_m) {
    return fail(Errc::limit_tripped,
                "the travel limits leave no room to press: {:.4f} mm of {:.4f} mm", *here_m * 1e3,
                permit.limits.travel_max.si() * 1e3);
  }
  return permit;
}

Result<Permit> permit_to_travel(const RigState& rig, double travel_m, double speed_m_s) {
  Permit permit = permit_retreat(rig);
  const auto here_m = rig.frame.seen.travel_m;
  if (here_m && travel_m <= *here_m) return permit;
  const auto contact_m = rig.contact.travel_m;
  const double depth_m = contact_m ? travel_m - *contact_m : 0;
  if (contact_m && depth_m <= 0) return permit;
  if (auto may = rig.trust.may_press(); !may) return fail(may.error());
  const Forecast& forecast = *rig.forecast;
  const double most_N = rig.force_max_N(), most_felt_N = most_N - zero_N(rig);
  permit.presses = true;
  permit.worst_N = zero_N(rig) + forecast.bound().force_after_N(rig.contact.force_N, depth_m);
  if (contact_m && !exceeds(permit.worst_N, most_N)) return permit;
  // Into the specimen, or towards one whose place is unknown, the frame has to stop early.
  const double trip_N = forecast.trip_N(speed_m_s, most_felt_N);
  const double least_N = least_trip_N(rig.frame.caps, rig.cell.noise_N());
  if (trip_N < least_N) {
    return fail(
        Errc::invalid_request,
        "{:.4g} mm/s towards {}: a stop at {:.3g} N may end beyond the limit of {:.4g} N; at "
        "most {:.3g} mm/s is allowed",
        speed_m_s * 1e3,
        contact_m ? "the inside of the specimen" : "a specimen that may be anywhere", least_N,
        most_N, forecast.fastest_m_s(least_N, most_felt_N) * 1e3);
  }
  permit.worst_N = most_N;
  permit.limits.force_max = Force::from_si(std::min(most_N, zero_N(rig) + trip_N));
  return permit;
}

Result<Permit> permit_ramp(const RigState& rig, double force_N, double rate_N_s) {
  Permit permit = permit_retreat(rig);
  const double from_N = rig.frame.force_N.value_or(zero_N(rig)) - zero_N(rig);
  const double to_N = force_N - zero_N(rig);
  if (to_N <= from_N) return permit;
  const auto& loop = rig.frame.caps.force_loop;
  if (!loop) {
    return fail(Errc::invalid_request, "nothing is known of what bounds the frame's force loop");
  }
  const Forecast& forecast = *rig.forecast;
  if (!forecast.loop_can_hold(to_N)) {
    return fail(
        Errc::invalid_request,
        "the contact may be {:.3g} N/mm stiff, the frame's force loop is good for {:.3g} N/mm",
        forecast.bound().stiffness_N_m(to_N) * 1e-3, loop->stiffness_max.si() * 1e-3);
  }
  permit.threshold_N = force_N;
  permit.presses = true;
  permit.worst_N = zero_N(rig) + forecast.ramp_N(from_N, to_N, rate_N_s);
  auto allowed = check(rig, permit.worst_N, force_N, loop->approach.si());
  if (!allowed) return fail(allowed.error());
  return permit;
}

bool explains(const RigState& rig, double felt_N, double stiffness_N_m, double force_N,
              double speed_m_s) {
  Forecast tried = *rig.forecast;
  tried.measured(felt_N, stiffness_N_m);
  return !is_beyond(felt_N, tried.stop_N(force_N, speed_m_s), rig.facts.frame.cell(),
                    rig.cell.noise_N());
}

}  // namespace lcrig
