// SPDX-License-Identifier: Apache-2.0
// How RigState follows the samples.
#include "protocols/rig/course.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/online.hpp"
#include "protocols/rig/corridor.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr double kLeastStep_m = 1e-10;  // no tolerance: a smaller change of the travel is rounding

}  // namespace

std::optional<ForceComparison> RigState::apply(const FrameSample& sample) {
  course.claim.reset();
  course.jump.reset();
  see(sample);
  std::optional<ForceComparison> late = prediction_.add(sample);
  trust_pressing(late);
  if (!is_watched() || !is_prepared) return late;
  if (frame.stands_from && sample.received >= *frame.stands_from) {
    stand(sample.received, std::nullopt);
  }
  if (frame.motion == FrameMotion::moving) see_moving(sample);
  if (frame.motion == FrameMotion::standing) see_standing(sample);
  return late;
}

void RigState::see(const FrameSample& s) {
  frame.seen.feed(s);
  frame.last_sample = s.received;
  frame.overloaded = (s.flags & frame_flag::kForceOverload) != 0;
  if (s.travel_m) {
    const double step_m = std::abs(*s.travel_m - course.last_travel_m.value_or(*s.travel_m));
    // A longer one is motion between two samples.
    const bool is_step = step_m > kLeastStep_m && step_m < kCoarsestStep_m;
    const bool finer = course.finest_step_m == 0 || step_m < course.finest_step_m;
    if (is_step && finer) course.finest_step_m = step_m;
    frame.shown_travel_m = course.last_travel_m = s.travel_m;
    course.travel_at = s.received;
    const auto old = course.old_zero_m;
    if (old && std::abs(*s.travel_m - *old) > kStanding_m) course.old_zero_m.reset();
  }
  if (s.force_N) {
    const bool counts = phase != RunPhase::finally || !course.is_force_known;
    if (counts) course.peak_force_N = std::max(course.peak_force_N, *s.force_N);
    const bool judged = frame.motion != FrameMotion::unknown;
    course.equal_forces = judged && course.last_N == s.force_N ? course.equal_forces + 1 : 1;
    course.last_N = s.force_N;
    course.place_before = std::exchange(course.place, Course::Place(*s.force_N, s.travel_m));
    frame.force_N = frame.shown_force_N = s.force_N;
    frame.force_at = s.received;
    course.is_force_known = true;
  } else if (frame.overloaded) {
    course.is_force_known = false;
  }
  // After an overload the travel alone is enough on a retreat.
  if (s.force_N || (frame.overloaded && phase == RunPhase::finally)) course.force_at = s.received;
}

void RigState::see_moving(const FrameSample& s) {
  if (s.travel_m) {
    see_claim(s);
    const double there_m = frame.order.direction * *s.travel_m;
    course.furthest_m = std::max(course.furthest_m.value_or(there_m), there_m);
  }
  if (s.force_N && trust.force) see_order_force(s.received, *s.force_N);
  if (s.travel_m && s.force_N && trust.force) {
    if (frame.order.direction < 0) {
      see_deepest(*s.travel_m, *s.force_N);
    } else {
      see_pressed(s);
    }
  }
  if (s.travel_m && s.force_N && trust.force) see_loop(s);
  if (s.travel_m && s.force_N) see_progress(s);
}

void RigState::see_order_force(MonoTime t, double force_N) {
  if (!std::exchange(frame.order.force_known, true)) frame.order.force_N = force_N;
  follow_filter(t, force_N);
  // The largest force that two consecutive samples of this motion reached.
  const double felt_N = std::min(force_N, course.before_N.value_or(force_N));
  course.peak_N = std::max(course.peak_N.value_or(felt_N), felt_N);
  course.before_N = force_N;
  const auto far_below = edge_from_peak(*this, t);
  course.fallen = far_below && force_N < far_below->value() ? course.fallen + 1 : 0;
  // It falls, so the filter has followed.
  const double tolerance_N =
      frame.order.against_N + frame.order.drift_N_s * to_seconds(t - frame.since);
  if (force_N < frame.order.force_N - tolerance_N) course.follows_until = MonoTime();
}

// While the cell's filter still follows the last motion, the force shown on a retreat may rise to
// what that motion can have reached. After a retreat it may fall to that of the unloaded cell while
// the frame comes closer again. It then counts as the force at the start.
void RigState::follow_filter(MonoTime t, double force_N) {
  Order& order = frame.order;
  if (order.direction < 0 && t <= course.follows_until) {
    order.force_N = std::max(order.force_N, std::min(force_N, course.follows_to_N));
  }
  if (!may_still_fall(t)) return;
  // A zero that was taken under load has moved what the unloaded cell shows.
  const double unloaded_N = std::min(order.zero_N, order.free_N.value_or(order.zero_N));
  order.force_N = std::min(order.force_N, std::max(force_N, unloaded_N));
  course.peak_N.reset();
  course.pressed.beyond_N.reset();
  course.pressed.best_N.reset();
}

// Follows the force against the depth in the contact, and counts forces below the corridor.
void RigState::see_pressed(const FrameSample& s) {
  if (!contact.least) return;
  Contact::Least& c = *contact.least;
  Course::Pressed& p = course.pressed;
  const double travel_m = *s.travel_m, felt_N = *s.force_N - p.zero_N;
  const double creep_s = kCreep_s * (frame.order.holds ? kHeldCreep : 1);
  const double crept_m =
      creep_s * std::max(0.0, felt_N) / c.stiffness_N_m * to_seconds(s.received - p.last);
  p.base_m += crept_m;
  p.crept_m += crept_m;
  p.last = s.received;
  if (travel_m > c.deepest_m) c.deepest_m = travel_m, c.deepest_N = felt_N;
  const double tolerance_N = tolerances.order_force_N + frame.order.loop_N +
                             frame.order.drift_N_s * to_seconds(s.received - frame.since);
  const bool feels = felt_N >= std::max(c.force_N, 2 * tolerance_N) &&
                     !is_clear_of_contact(*this, s.received, travel_m);
  const bool presses = is_in_contact(*this, s.received, travel_m) || p.best_N || feels;
  if (presses) {
    const double beyond_N = felt_N - kStiffFar * c.stiffness_N_m * (travel_m - p.crept_m);
    const double surely_N = std::min(beyond_N, p.beyond_N.value_or(beyond_N));  // ignores a spike
    p.beyond_N = beyond_N;
    if (!p.best_N || surely_N >= *p.best_N) {
      p.best_N = surely_N;
      p.best_at = s.received;
      p.best_m = travel_m;
    }
  }
  const auto least = edge_in_contact(*this, s.received, travel_m);
  p.too_small = least && *s.force_N < least->value() ? p.too_small + 1 : 0;
}

// The force may relax at standstill, and fall on a retreat.
void RigState::see_deepest(double travel_m, double force_N) {
  if (!contact.least || travel_m < contact.least->deepest_m - kPlace_m) return;
  contact.least->deepest_m = std::max(contact.least->deepest_m, travel_m);
  contact.least->deepest_N = force_N - frame.order.zero_N;
}

// A force loop that is further from its set point than its ripple, its lag and the noise explain
// moves towards it.
void RigState::see_loop(const FrameSample& s) {
  const Order& order = frame.order;
  if (order.direction != 0 || !order.to_N) return;
  const double seconds = to_seconds(s.received - frame.since);
  const double way_N = *order.to_N - order.force_N;
  const double part_N =
      order.holds ? std::abs(way_N) : std::min(order.rate_N_s * seconds, std::abs(way_N));
  const double off_N = order.force_N + std::copysign(part_N, way_N) - *s.force_N;
  const double tolerance_N =
      tolerances.order_force_N + order.loop_N + order.against_N + order.drift_N_s * seconds;
  if (std::abs(off_N) <= tolerance_N) return course.loop.reset();
  const double direction = std::copysign(1, off_N), there_m = direction * *s.travel_m;
  if (!course.loop || course.loop->direction != direction) course.loop = {direction, there_m, 0};
  course.loop->furthest_m = std::max(course.loop->furthest_m, there_m);
  course.loop->wrong_m = course.loop->furthest_m - there_m;
}

void RigState::see_progress(const FrameSample& s) {
  const Order& order = frame.order;
  const bool by_loop = order.direction == 0;
  if (by_loop && !(order.rate_N_s > 0)) return;
  if (!course.progress) course.progress.emplace(s.received, *s.travel_m, *s.force_N);
  Course::Idle part;
  part.seconds = to_seconds(s.received - course.progress->t);
  if (part.seconds < stall_s() / kQuarters) return;
  part.way_m = std::abs(*s.travel_m - course.progress->travel_m);
  part.moves = part.way_m >= kProgress * order.speed_m_s * part.seconds;
  const double change_N = std::abs(*s.force_N - course.progress->force_N);
  const bool loads = by_loop && change_N >= kLeastRate * order.rate_N_s * part.seconds;
  // A force loop that moves in a contact which should push back, and does not, is no progress.
  const bool pushes = by_loop && contact.least;
  const double should_N = pushes ? contact.least->stiffness_at_N_m(*s.travel_m) * part.way_m : 0;
  const bool follows = change_N >= kLeastRate * should_N;
  course.idle = loads || (part.moves && follows) ? 0 : course.idle + 1;
  course.last_idle = part;
  course.progress.emplace(s.received, *s.travel_m, *s.force_N);
}

void RigState::see_standing(const FrameSample& s) {
  const bool settled = s.received - frame.since > from_seconds(kUnderWay_s + kBatch_s);
  const bool moving = settled && (s.flags & frame_flag::kMoving) != 0;
  course.moving_flags = moving ? course.moving_flags + 1 : 0;
  if (s.travel_m && !course.stood_m) course.stood_m = s.travel_m;
  if (s.force_N && settled) see_relaxation(s.received, *s.force_N);
  if (s.force_N && s.travel_m) see_deepest(*s.travel_m, *s.force_N);
  if (s.travel_m && to_seconds(s.received - frame.since) > tolerances.settled_s) see_claim(s);
  if (s.force_N) see_jump(s);
}

// Compares the first sample that counts with the place where the frame reported to stand. When a
// motion follows at once, no sample of that standstill has come.
void RigState::see_claim(const FrameSample& s) {
  if (!frame.reported_m) return;
  const double reported_m = *std::exchange(frame.reported_m, std::nullopt);
  double way_m = 0;
  if (frame.motion == FrameMotion::moving) {
    if (frame.order.direction == 0) return;
    way_m = kSpeedAllowance * frame.order.speed_m_s *
            (to_seconds(s.received - frame.since) + kUnderWay_s);
  }
  course.claim.emplace(reported_m, *s.travel_m,
                       tolerances.order_travel_m + way_m + kTravelSteps * travel_step_m());
}

void RigState::see_relaxation(MonoTime t, double force_N) {
  const auto smooth = [&](Course::Seen& s, double weight) {
    s.t = t;
    s.force_N += weight * (force_N - s.force_N);
  };
  if (!course.stood_first) course.stood_first.emplace(t, force_N);
  if (!course.stood_last) course.stood_last.emplace(t, force_N);
  const double off_N = force_N - course.stood_last->force_N;
  course.noise_N2 += kSmoothSquare * (off_N * off_N - course.noise_N2);
  if (to_seconds(t - frame.since) < kObserved_s) smooth(*course.stood_first, kSmooth);
  smooth(*course.stood_last, kSmooth);
}

void RigState::see_jump(const FrameSample& s) {
  const MonoTime t = s.received;
  if (!trust.force || t - std::max(frame.since, frame.zeroed_at) < kJumpSettled_s.duration())
    return;
  auto& recent = course.recent;
  recent.emplace_back(t, *s.force_N);
  if (t - course.compared < kBatch_s.duration()) return;
  course.compared = t;
  while (t - recent.front().t > from_seconds(kJumpApart_s + kLook_s)) recent.pop_front();
  std::vector<double> old_N, new_N;
  double steepest_N = 0;  // largest change between two samples
  for (std::size_t i = 1; i < recent.size(); ++i) {
    steepest_N = std::max(steepest_N, std::abs(recent[i].force_N - recent[i - 1].force_N));
  }
  for (const Course::Seen& seen : recent) {
    if (t - seen.t >= kJumpApart_s.duration()) old_N.push_back(seen.force_N);
    if (t - seen.t <= kLook_s.duration()) new_N.push_back(seen.force_N);
  }
  if (old_N.size() < 2 || new_N.size() < 2) return;
  const double before_N = upper_median(old_N), after_N = upper_median(new_N);
  const double felt_N = std::max(std::abs(before_N), std::abs(after_N));
  const double allowed_N =
      std::max(2 * tolerances.contact_force_N, tolerances.order_force_N) + kJump * felt_N;
  const double change_N = std::abs(after_N - before_N);
  // Relaxation and creep take many small steps.
  if (change_N <= allowed_N || steepest_N < kOneStep * change_N) return;
  const double way_m = s.travel_m && course.stood_m ? std::abs(*s.travel_m - *course.stood_m) : 0;
  const bool moves =
      way_m > std::max(kWithForce * tolerances.standing_m, kTravelSteps * travel_step_m());
  course.jump.emplace(before_N, after_N, moves);
}

}  // namespace lcrig
