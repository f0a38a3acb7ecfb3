// SPDX-License-Identifier: Apache-2.0
// The corridor of the travel: a sample outside it, and a frame that makes no progress inside it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "protocols/checks/checks.hpp"
#include "protocols/rig/corridor.hpp"

namespace lcrig::checks {

Found place_after_motion(const RigState& rig, const Sight& /*sight*/) {
  const auto& claim = rig.course.claim;
  if (!claim || std::abs(claim->shown_m - claim->reported_m) <= claim->allowed_m) {
    return std::nullopt;
  }
  if (rig.frame.motion == FrameMotion::moving) {
    return fmt::format("the frame said that it stands at {:.4f} mm, and shows {:.4f} mm",
                       claim->reported_m * 1e3, claim->shown_m * 1e3);
  }
  return fmt::format(
      "the frame moves without a command: it said that it stands at {:.4f} mm, and shows {:.4f} mm",
      claim->reported_m * 1e3, claim->shown_m * 1e3);
}

Found against_order(const RigState& rig, const Sight& sight) {
  const auto edge = edge_behind(rig);
  const double direction = rig.frame.order.direction;
  const auto& travel_m = sight.sample.travel_m;
  if (!edge || !travel_m || direction * (*travel_m - edge->value()) >= 0) return std::nullopt;
  return fmt::format(
      "the frame runs against the command: {:.4f} mm {} the specimen instead of {} it",
      std::abs(*travel_m - edge->terms().front().value) * 1e3,
      direction > 0 ? "away from" : "towards", direction > 0 ? "towards" : "away from");
}

// The first sample of a motion is compared with the reported place instead.
Found ahead_of_order(const RigState& rig, const Sight& sight) {
  const auto edge = edge_ahead(rig, sight.sample.received);
  const auto& travel_m = sight.sample.travel_m;
  if (!edge || !travel_m || rig.course.claim) return std::nullopt;
  if (rig.frame.order.direction * (*travel_m - edge->value()) <= 0) return std::nullopt;
  return fmt::format(
      "the frame is ahead of the command: {:.4f} mm after {:.1f} s from {:.4f} mm, where {:.4g} "
      "mm/s were ordered",
      *travel_m * 1e3, to_seconds(sight.sample.received - rig.frame.since),
      edge->terms().front().value * 1e3, rig.frame.order.speed_m_s * 1e3);
}

// A force that changes together with the travel is real.
Found moves_at_standstill(const RigState& rig, const Sight& sight) {
  const auto& stood_m = rig.course.stood_m;
  const double way_m = sight.sample.travel_m && stood_m ? *sight.sample.travel_m - *stood_m : 0;
  const bool flagged = rig.course.moving_flags >= kTwice.count();
  const bool creeps =
      std::abs(way_m) > rig.standing_m() || (rig.course.jump && rig.course.jump->moves);
  if (!flagged && !creeps) return std::nullopt;
  return fmt::format("the frame moves without a command: {:+.4f} mm since it stood{}", way_m * 1e3,
                     flagged ? ", and it says that it moves" : "");
}

Found stalls(const RigState& rig, const Sight& /*sight*/) {
  const auto& idle = rig.course.last_idle;
  if (rig.course.idle < kQuarters.count() || rig.frame.order.direction == 0) return std::nullopt;
  return fmt::format(
      "the frame does not move as it was told to, and does not say that it stands: {:.4f} mm in "
      "the last {:.1f} s, where {:.4g} mm/s were ordered",
      idle.way_m * 1e3, idle.seconds, rig.frame.order.speed_m_s * 1e3);
}

// Whether it is the cell or the drive that does nothing: a retreat shows it.
Found loop_without_force(const RigState& rig, const Sight& sight) {
  const auto& idle = rig.course.last_idle;
  const bool is_loop = rig.frame.order.direction == 0;
  if (rig.course.idle < kQuarters.count() || !is_loop || !sight.sample.force_N) return std::nullopt;
  return fmt::format(
      "the force loop {}, {:.4f} mm in the last {:.1f} s, and the force does not follow: {:.4f} N, "
      "where {:.4g} N/s were ordered; the load cell shows too little, the specimen gave way, or "
      "the "
      "drive stands",
      idle.moves ? "goes on" : "does not move", idle.way_m * 1e3, idle.seconds,
      *sight.sample.force_N, rig.frame.order.rate_N_s);
}

Found loop_runs_away(const RigState& rig, const Sight& sight) {
  const auto& loop = rig.course.loop;
  if (!loop || !sight.sample.force_N || loop->wrong_m <= rig.still_m()) return std::nullopt;
  return fmt::format(
      "the force loop runs against the command: {:.4f} mm {} the specimen at {:.4f} N, where "
      "{:.4f} "
      "N were ordered",
      loop->wrong_m * 1e3, loop->direction > 0 ? "away from" : "towards", *sight.sample.force_N,
      *rig.frame.order.to_N);
}

}  // namespace lcrig::checks
