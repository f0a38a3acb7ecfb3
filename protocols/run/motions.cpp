// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/motions.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "base/either.hpp"
#include "protocols/rig/corridor.hpp"
#include "protocols/rig/permit.hpp"
#include "protocols/run/event_log.hpp"
#include "protocols/run/frame_drive.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/rest_meter.hpp"
#include "protocols/run/scoped_flag.hpp"
#include "protocols/run/setup.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

// Whether a single force value shows that the target was reached from the side of `direction`.
bool is_there(double force_N, double target_N, int direction, double allowed_N) {
  if (direction == 0) return std::abs(force_N - target_N) <= allowed_N;
  return direction > 0 ? force_N >= target_N - allowed_N : force_N <= target_N + allowed_N;
}

// Turns every end other than `target` into an error, which stops the protocol.
Result<MotionOutcome> judge_end(const std::string& step, const MotionOrder& order,
                                MotionOutcome outcome) {
  // The device's own words.
  const std::string said = outcome.detail.empty() ? "" : ": " + outcome.detail;
  switch (outcome.reason) {
    case MotionEnd::target: return outcome;
    case MotionEnd::force_limit:
      return fail(Errc::limit_tripped, "step {}: the frame stopped at its force limit{}", step,
                  said);
    case MotionEnd::travel_limit:
      if (order.by_contact && order.force_N) {
        return fail(Errc::limit_tripped,
                    "step {}: the frame stopped where the contact that was found must show "
                    "{:.4g} N at least: the load cell shows too little, or the specimen gave way{}",
                    step, *order.force_N, said);
      }
      return fail(Errc::limit_tripped, "step {}: the frame stopped at its travel limit{}", step,
                  said);
    case MotionEnd::stopped:
      return fail(Errc::aborted, "step {}: the frame was stopped at the machine{}", step, said);
    case MotionEnd::fault: break;
  }
  return fail(Errc::refused, "step {}: the frame reports a fault{}", step, said);
}

}  // namespace

Motions::Motions(const RunSetup& setup, const EventLog& log, FrameWatch& watch, RestMeter& meter,
                 FrameDrive& drive)
    : setup_(setup), log_(log), watch_(watch), rig_(watch.rig()), meter_(meter), drive_(drive) {}

// Runs the motion with a time-out and writes its event. Every end other than `target` is an error.
Task<Result<MotionOutcome>> Motions::timed(const MotionOrder& order,
                                           Task<Result<MotionOutcome>> motion, TimeLimit limit) {
  if (auto may = drive_.may_move(); !may) co_return fail(may.error());
  const auto too_long = [&] {
    return fail(Errc::no_reply, "step {}: the motion did not end within {:.6g} s", log_.step_id(),
                limit.seconds);
  };
  TimeSpent of_this;
  TimeSpent& time = limit.spent != nullptr ? *limit.spent : of_this;
  const MonoTime now = setup_.clock.now(), deadline = time.begin(now, from_seconds(limit.seconds));
  if (deadline == now) co_return too_long();  // a motion would begin for nothing
  drive_.will_hold(std::nullopt);
  watch_.order(order.motion);
  drive_.note_order(order.motion.speed_m_s);
  last_speed_m_s_ = order.motion.speed_m_s;
  const ScopedFlag moving(in_motion_);
  auto r = co_await either(std::move(motion), setup_.clock.wait_until(deadline));
  time.end(setup_.clock.now());
  if (r.index() == 1) co_return too_long();
  auto& outcome = std::get<0>(r);
  if (!outcome) {
    watch_.lose_motion();  // nobody knows whether it moves now
    co_return fail(outcome.error());
  }
  log_.event(ended_event<EventKind::motion>(*outcome));
  see_end(order, *outcome);
  const double end_N = outcome->force_N.value_or(rig_.frame.force_N.value_or(0));
  const bool fell = end_N < order.motion.force_N;
  if (order.either_side && outcome->reason == MotionEnd::force_limit && fell) co_return *outcome;
  co_return judge_end(log_.step_id(), order, std::move(*outcome));
}

void Motions::see_end(const MotionOrder& order, const MotionOutcome& outcome) {
  watch_.motion_stood(outcome);
  const bool holds = order.motion.direction == 0 && outcome.reason == MotionEnd::target;
  if (holds) {
    watch_.order(rig_.hold_now(order.force_N.value_or(0), meter_.noise_N()));
  } else {
    watch_.stand(outcome.travel_m);
  }
}

// How far the frame is from the intended end of the motion, by its own report and by its samples.
// Empty when both agree with it.
std::string Motions::disagreement(const MotionOrder& order, const MotionOutcome& outcome) const {
  const Tolerances& f = rig_.tolerances;
  if (order.travel_m) {
    for (const auto& x : {outcome.travel_m, rig_.frame.shown_travel_m}) {
      if (!x || std::abs(*x - *order.travel_m) <= f.order_travel_m) continue;
      return fmt::format("it was to go to {:.4f} mm, and shows {:.4f} mm", *order.travel_m * 1e3,
                         *x * 1e3);
    }
  }
  if (!order.force_N || !rig_.trust.force) return {};
  const double rest_N = rig_.cell.zero_N();
  const double felt_N =
      std::max(std::abs(*order.force_N - rest_N), std::abs(order.motion.force_N - rest_N));
  const double allowed_N =
      f.order_force_N + order.loop_N + kSettles * felt_N + rig_.zero_uncertainty_N();
  for (const auto& force : {outcome.force_N, rig_.frame.shown_force_N}) {
    if (!force || is_there(*force, *order.force_N, order.side, allowed_N)) continue;
    return fmt::format("it was to go to {:.4f} N, and shows {:.4f} N", *order.force_N, *force);
  }
  return {};
}

Task<Result<>> Motions::confirm_end(const MotionOrder& order, const MotionOutcome& outcome) const {
  if (!rig_.is_watched() || outcome.reason != MotionEnd::target) co_return Result<>();
  const MonoTime limit = setup_.clock.now() + from_seconds(rig_.tolerances.settled_s);
  std::string why = disagreement(order, outcome);
  while (!why.empty() && setup_.clock.now() < limit) {
    co_await setup_.clock.wait_for(10ms);
    why = disagreement(order, outcome);
  }
  if (why.empty()) co_return Result<>();
  log_.event(EventKind::contradiction, why);
  co_return fail(Errc::refused, "step {}: the frame says DONE, but that is not true: {}",
                 log_.step_id(), why);
}

// Arms the frame, moves, and compares the felt force with the predicted one.
Task<Result<MotionOutcome>> Motions::watched(MotionOrder order, Permit permit,
                                             Task<Result<MotionOutcome>> motion, TimeLimit limit) {
  auto ready = co_await ready_for(permit);
  if (!ready) co_return fail(ready.error());
  watch_.permit(permit);
  if (permit.presses) order.motion.worst_N = permit.worst_N;
  auto outcome = co_await timed(order, std::move(motion), limit);
  if (!rig_.forecast || !outcome) co_return outcome;
  auto true_word = co_await confirm_end(order, *outcome);
  if (!true_word) co_return fail(true_word.error());
  const auto seen = watch_.compare(*outcome, rig_.cell.noise_bound_N());
  if (!seen) co_return outcome;
  report(*seen);
  if (!seen->exceeded || seen->observed_N <= rig_.force_max_N()) co_return outcome;
  co_return fail(Errc::limit_tripped, "step {}: the force went to {:.4f} N, the limit is {:.4f} N",
                 log_.step_id(), seen->observed_N, rig_.force_max_N());
}

void Motions::report(const ForceComparison& seen) const {
  if (seen.exceeded) {
    log_.event(seen.event<EventKind::overshoot_exceeded>());
  } else {
    log_.event(seen.event<EventKind::overshoot>());
  }
}

// A motion that presses needs a cell that was seen to be alive.
Task<Result<>> Motions::ready_for(const Permit& permit) {
  if (permit.presses && rig_.needs_live_cell()) {
    auto rest = co_await meter_.measure_alive();
    if (!rest) co_return fail(rest.error());
    watch_.see_alive(*rest);
  }
  co_return co_await drive_.arm(permit.limits);
}

MotionOrder Motions::order_of(double force_N, int side, double speed_m_s) const {
  MotionOrder order;
  order.force_N = force_N;
  order.side = side;
  order.motion = rig_.order_now(side, speed_m_s, meter_.noise_N());
  return order;
}

tl::unexpected<Error> Motions::refused(const Error& error) const {
  return fail(error.code, "step {}: {}", log_.step_id(), error.what);
}

Task<Result<>> Motions::to_travel(double travel_m, double speed_m_s, TimeLimit limit) {
  const auto here_m = rig_.frame.seen.travel_m;
  if (!rig_.trust.force && here_m && travel_m > *here_m) {
    log_.event(EventKind::skipped,
               "it leads towards the specimen, and the force is not believed any more");
    co_return Result<>();
  }
  Permit permit;
  if (rig_.forecast) {
    if (!here_m) {
      co_return fail(Errc::no_reply, "step {}: the frame sends no travel", log_.step_id());
    }
    auto allowed = permit_to_travel(rig_, travel_m, speed_m_s);
    if (!allowed) co_return refused(allowed.error());
    permit = *allowed;
  }
  MotionOrder order;
  order.travel_m = travel_m;
  const bool away = here_m && travel_m <= *here_m;
  order.motion = rig_.order_now(away ? -1 : 1, speed_m_s, meter_.noise_N());
  order.motion.target_m = travel_m;
  auto motion = setup_.frame.move_to(Length::from_si(travel_m), Velocity::from_si(speed_m_s));
  auto outcome = co_await watched(order, permit, std::move(motion), limit);
  if (!outcome) co_return fail(outcome.error());
  co_return Result<>();
}

Task<Result<MotionOutcome>> Motions::press_until(double force_N, double speed_m_s, TimeLimit limit,
                                                 std::optional<Search> search) {
  auto permit = permit_to_force(rig_, force_N, speed_m_s);
  if (!permit) co_return refused(permit.error());
  Length guard = permit->guard;
  MotionOrder order = order_of(force_N, 1, speed_m_s);
  if (search) {
    guard = std::min(guard, Length::from_si(search->end_m));
    permit->limits.force_min = std::max(permit->limits.force_min, Force::from_si(search->least_N));
    order.either_side = true;
    const double fall_N = order.motion.force_N - search->least_N;
    order.motion.against_N = std::max(order.motion.against_N, 2 * fall_N);
  } else if (const auto end_m = furthest_m(rig_, setup_.clock.now(), force_N);
             end_m && *end_m < guard.si()) {
    guard = Length::from_si(*end_m);
    order.by_contact = true;
  }
  auto motion =
      setup_.frame.move_until_force(Force::from_si(force_N), Velocity::from_si(speed_m_s), guard);
  co_return co_await watched(order, *permit, std::move(motion), limit);
}

Task<Result<>> Motions::to_force(double force_N, double speed_m_s, TimeLimit limit) {
  const auto present = meter_.present_force_N();
  if (!present) co_return fail(present.error());
  Result<MotionOutcome> outcome;
  if (force_N >= *present) {
    outcome = co_await press_until(force_N, speed_m_s, limit, std::nullopt);
  } else {
    const Permit permit = permit_retreat(rig_);
    const MotionOrder order = order_of(force_N, -1, speed_m_s);
    auto motion = setup_.frame.move_until_force(
        Force::from_si(force_N), Velocity::from_si(-speed_m_s), permit.limits.travel_min);
    outcome = co_await watched(order, permit, std::move(motion), limit);
  }
  if (!outcome) co_return fail(outcome.error());
  co_return Result<>();
}

Task<Result<>> Motions::ramp_to_force(double force_N, double rate_N_s, TimeLimit limit) {
  const auto present = meter_.present_force_N();
  if (!present) co_return fail(present.error());
  auto permit = permit_ramp(rig_, force_N, rate_N_s);
  if (!permit) co_return refused(permit.error());
  MotionOrder order = order_of(force_N, 0, 0);
  order.motion.rate_N_s = rate_N_s;
  order.motion.to_N = force_N;
  if (const auto& loop = setup_.frame.capabilities().force_loop) {
    order.motion.speed_m_s = loop->approach.si();
    order.loop_N = loop->ripple.si() + rate_N_s * to_seconds(loop->lag);
    order.motion.loop_N = order.loop_N;
  }
  auto motion = setup_.frame.ramp_force(Force::from_si(force_N), ForceRate::from_si(rate_N_s));
  auto outcome = co_await watched(order, *permit, std::move(motion), limit);
  if (!outcome) co_return fail(outcome.error());
  drive_.will_hold(force_N);
  co_return Result<>();
}

}  // namespace lcrig
