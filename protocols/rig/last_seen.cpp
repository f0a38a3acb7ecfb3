// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/last_seen.hpp"

#include <algorithm>
#include <cmath>

#include "protocols/rig/constants.hpp"

namespace lcrig {

namespace {

// Distance that a moving frame covers until it stands: it moves on until the gateway notices, then
// brakes. The speed is an estimate, so half of it is added.
double way_m(const LastSeen& before, const FrameTolerance& allowed) {
  const double v = std::max(1.5 * before.speed_m_s, before.begun_m_s);
  const double a = allowed.deceleration.si();
  return v * to_seconds(allowed.silence) + (a > 0 ? v * v / (2 * a) : 0);
}

// Refuses a force that does not fit the way. Closer to the specimen it must not be smaller, nor
// larger than the stiffest contact allows; further away the other way round.
Result<> compare_force_on_way(const LastSeen& before, const LastSeen& now,
                              const FrameTolerance& allowed) {
  if (!before.zeroed || !allowed.force_after_N || !before.force_N || !now.force_N) return {};
  const bool closer = *now.travel_m >= *before.travel_m;
  const double far_N = closer ? *before.force_N : *now.force_N;
  const double near_N = closer ? *now.force_N : *before.force_N;
  const double way_m = std::abs(*now.travel_m - *before.travel_m);
  const double most_N =
      allowed.rest_N + allowed.force_after_N(std::max(0.0, far_N - allowed.rest_N), way_m);
  const double doubt_N = allowed.force_N + kNoiseSigmas * allowed.noise_N +
                         std::max(allowed.cell.error_N(far_N), allowed.cell.error_N(near_N));
  if (near_N >= far_N - doubt_N && near_N <= most_N + doubt_N) return {};
  return fail(Errc::refused,
              "the frame shows {:.4f} N at {:.4f} mm, last seen {:.4f} N at {:.4f} mm: no contact "
              "does that, the zero of force or travel was lost or changed",
              *now.force_N, *now.travel_m * 1e3, *before.force_N, *before.travel_m * 1e3);
}

}  // namespace

void LastSeen::feed(const FrameSample& s) {
  const bool timed = s.travel_m && travel_m && s.device_time_s && device_time_s;
  const double dt_s = timed ? *s.device_time_s - *device_time_s : 0;
  if (dt_s > 0) speed_m_s = std::abs(*s.travel_m - *travel_m) / dt_s;
  if ((s.flags & frame_flag::kMoving) == 0) speed_m_s = 0;
  if (s.travel_m) travel_m = s.travel_m;
  if (s.device_time_s) device_time_s = s.device_time_s;
  force_N = s.force_N;
}

Result<> compare_frame(const LastSeen& before, const LastSeen& now, const FrameTolerance& allowed) {
  const bool restarted =
      before.device_time_s && now.device_time_s && *now.device_time_s < *before.device_time_s;
  if (restarted && before.zeroed) {
    return fail(Errc::refused,
                "the frame came back with its clock at {:.1f} s after {:.1f} s: it was restarted "
                "and may have forgotten its zero",
                *now.device_time_s, *before.device_time_s);
  }
  if (!before.travel_m || !now.travel_m) {
    return fail(Errc::refused, "the frame came back, but its travel is not known");
  }
  const double limit_m = allowed.travel_m + way_m(before, allowed);
  const double moved_m = std::abs(*now.travel_m - *before.travel_m);
  if (moved_m > limit_m) {
    return fail(Errc::refused,
                "the frame stands at {:.4f} mm, last seen at {:.4f} mm ({:.4f} mm allowed): it was "
                "moved meanwhile, or went on after the last sample",
                *now.travel_m * 1e3, *before.travel_m * 1e3, limit_m * 1e3);
  }
  const bool stood = before.speed_m_s == 0 && moved_m <= allowed.travel_m;
  if (!stood) return compare_force_on_way(before, now, allowed);
  if (!before.force_N) return {};
  if (!now.force_N || std::abs(*now.force_N - *before.force_N) > allowed.force_N) {
    return fail(Errc::refused,
                "the frame shows {:.4f} N, last seen {:.4f} N at the same travel ({:.4f} N "
                "allowed): check its zero and the specimen",
                now.force_N.value_or(std::nan("")), *before.force_N, allowed.force_N);
  }
  return {};
}

}  // namespace lcrig
