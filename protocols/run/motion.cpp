// SPDX-License-Identifier: Apache-2.0
// One motion of a run: whether it may begin, what the device watches meanwhile, what came of it;
// and what the frame shows while it stands.
#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <cmath>
#include <utility>
#include <variant>

#include "protocols/run/run.hpp"

namespace lcrig {

namespace {

using namespace asio::experimental::awaitable_operators;
using namespace std::chrono_literals;

constexpr Duration kForceAge = 500ms;  // an older force says nothing of the way to go
constexpr Duration kLifeTime = 3s;  // a live cell changes its last digit within this
constexpr std::int64_t kRestSamples = 10;

// Everything but `target` keeps the protocol from going on.
Result<MotionOutcome> judge(const std::string& step, MotionOutcome outcome) {
  const std::string& detail = outcome.detail;
  switch (outcome.reason) {
    case MotionEnd::target: return outcome;
    case MotionEnd::force_limit:
      return fail(Errc::limit_tripped, "step {}: the frame stopped at its force limit {}", step,
                  detail);
    case MotionEnd::travel_limit:
      return fail(Errc::limit_tripped, "step {}: the frame stopped at its travel limit {}", step,
                  detail);
    case MotionEnd::stopped:
      return fail(Errc::aborted, "step {}: the frame was stopped at the machine {}", step, detail);
    case MotionEnd::fault: break;
  }
  return fail(Errc::refused, "step {}: the frame reports a fault {}", step, detail);
}

}  // namespace

Task<Result<>> Run::arm(FrameLimits limits) {
  const auto same = [](const FrameLimits& a, const FrameLimits& b) {
    return a.force_min == b.force_min && a.force_max == b.force_max &&
           a.travel_min == b.travel_min && a.travel_max == b.travel_max &&
           a.speed_max == b.speed_max;
  };
  if (auto may = may_move(); !may) co_return may;
  if (armed_ && same(*armed_, limits)) co_return Result<>();
  auto armed = co_await setup_.frame.arm(limits);
  if (armed) armed_ = limits;
  co_return armed;
}

Task<Result<MotionOutcome>> Run::timed(const Order& order, Task<Result<MotionOutcome>> motion,
                                       double timeout_s) {
  if (auto may = may_move(); !may) co_return fail(may.error());
  held_force_N_.reset();
  if (plausible_) plausible_->begin(order.motion, setup_.clock.now());
  in_motion_ = true;
  order_speed_m_s_ = order.motion.speed_m_s;
  const auto over = [](bool* flag) { *flag = false; };
  const std::unique_ptr<bool, decltype(over)> moving(&in_motion_, over);
  const MonoTime deadline = setup_.clock.now() + from_seconds(timeout_s);
  auto r = co_await (std::move(motion) || setup_.clock.wait_until(deadline));
  if (r.index() == 1) {
    co_return fail(Errc::no_reply, "step {}: the motion did not end within {} s", step_->id,
                   timeout_s);
  }
  auto& outcome = std::get<0>(r);
  if (!outcome) {
    if (plausible_) plausible_->look_away();  // whether it moves now, nobody knows
    co_return fail(outcome.error());
  }
  event(ended_event<EventKind::motion>(*outcome));
  see_end(order, *outcome);
  const bool fell = outcome->force_N.value_or(force_N_.value_or(0)) < order.motion.force_N;
  if (order.either_side && outcome->reason == MotionEnd::force_limit && fell) co_return *outcome;
  co_return judge(step_->id, std::move(*outcome));
}

// Where it stands is newer than the last sample, which at ten samples per second is one of the
// motion: the next step would take a force or a way for one that leads the other way.
void Run::take_standstill(const MotionOutcome& outcome) {
  guard_.take_standstill(outcome.force_N, outcome.travel_m);
  done_force_N_ = outcome.force_N;
  if (outcome.travel_m) memory_.travel_m = outcome.travel_m;
  if (!outcome.force_N) return;
  force_N_ = outcome.force_N;
  force_known_ = setup_.clock.now();
}

void Run::see_end(const Order& order, const MotionOutcome& outcome) {
  take_standstill(outcome);
  if (!plausible_) return;
  const bool holds = order.motion.direction == 0 && outcome.reason == MotionEnd::target;
  if (holds) {
    plausible_->begin(holding(), setup_.clock.now());
  } else {
    plausible_->stand(setup_.clock.now(), outcome.travel_m);
  }
}

// Arms, moves, and compares what was felt with what was predicted.
Task<Result<MotionOutcome>> Run::watched(Order order, Permit permit,
                                         Task<Result<MotionOutcome>> motion, double timeout_s) {
  auto ready = co_await ready_for(permit);
  if (!ready) co_return fail(ready.error());
  if (pressing_) pressing_->begin(permit);
  auto outcome = co_await timed(order, std::move(motion), timeout_s);
  if (!pressing_ || !outcome) co_return outcome;
  auto true_word = co_await believe(order, *outcome);
  if (!true_word) co_return fail(true_word.error());
  const auto seen = pressing_->end(*outcome, rest_ ? rest_->scatter_N() : 0);
  if (!seen) co_return outcome;
  if (seen->exceeded) {
    event(seen->event<EventKind::overshoot_exceeded>());
  } else {
    event(seen->event<EventKind::overshoot>());
  }
  if (!seen->exceeded || seen->observed_N <= guard_.force_max_N()) co_return outcome;
  co_return fail(Errc::limit_tripped, "step {}: the force went to {:.4f} N, the limit is {:.4f} N",
                 step_->id, seen->observed_N, guard_.force_max_N());
}

// Nothing is pressed with a cell that never was seen to scatter.
Task<Result<>> Run::ready_for(const Permit& permit) {
  if (permit.presses && plausible_ && !scatter_.alive) {
    auto rest = co_await living_rest();
    if (!rest) co_return fail(rest.error());
    scatter_ = ForceScatter(*rest);
  }
  auto armed = co_await arm(permit.limits);
  co_return armed;
}

Pressing::State Run::pressing_state() const {
  Pressing::State now;
  now.limits = guard_.limits();
  now.force_max_N = guard_.force_max_N();
  if (rest_) {
    // What is within the noise is none, as in the plan: else the speed that it accepted is refused.
    now.noise_N = rest_->scatter_N();
    const double rest_N = rest_->force_N();
    now.rest_N = std::abs(rest_N) > kNoiseSigmas * now.noise_N ? rest_N : 0;
  }
  now.travel_m = memory_.travel_m;
  now.force_N = force_N_;
  now.contact_m = contact_travel_m_;
  now.contact_N = contact_force_N_;
  return now;
}

Result<double> Run::present_force() const {
  const Duration age = setup_.clock.now() - force_known_;
  const double period_s = 1 / setup_.frame_rate_Hz;
  const Duration most = std::max<Duration>(kForceAge, from_seconds(3 * period_s));
  if (force_N_ && age <= most) return *force_N_;
  if (!force_N_) return fail(Errc::no_reply, "step {}: the frame sends no force", step_->id);
  return fail(
      Errc::no_reply,
      "step {}: the last known force, {:.4f} N, is {:.1f} s old: nobody knows which way leads "
      "to less",
      step_->id, *force_N_, to_seconds(age));
}

Run::Order Run::order_of(double force_N, int side, double speed_m_s) const {
  Order order;
  order.force_N = force_N;
  order.side = side;
  order.motion = motion_now(side, speed_m_s);
  return order;
}

Task<Result<>> Run::move_to_travel(double travel_m, double speed_m_s, double timeout_s) {
  if (guard_.is_distrusted() && memory_.travel_m && travel_m > *memory_.travel_m) {
    event(EventKind::skipped,
          "it leads towards the specimen, and the force is not believed any more");
    co_return Result<>();
  }
  Permit permit;
  if (pressing_) {
    if (!memory_.travel_m) {
      co_return fail(Errc::no_reply, "step {}: the frame sends no travel", step_->id);
    }
    auto allowed = pressing_->to_travel(pressing_state(), travel_m, speed_m_s);
    if (!allowed)
      co_return fail(allowed.error().code, "step {}: {}", step_->id, allowed.error().what);
    permit = *allowed;
  }
  Order order;
  order.travel_m = travel_m;
  const bool away = memory_.travel_m && travel_m <= *memory_.travel_m;
  order.motion = motion_now(away ? -1 : 1, speed_m_s);
  order.motion.target_m = travel_m;
  auto motion = setup_.frame.move_to(Length::from_si(travel_m), Velocity::from_si(speed_m_s));
  auto outcome = co_await watched(order, permit, std::move(motion), timeout_s);
  if (!outcome) co_return fail(outcome.error());
  co_return Result<>();
}

Task<Result<MotionOutcome>> Run::press_until(double force_N, double speed_m_s, double timeout_s,
                                             std::optional<Search> search) {
  auto permit = pressing_->to_force(pressing_state(), force_N, speed_m_s);
  if (!permit) co_return fail(permit.error().code, "step {}: {}", step_->id, permit.error().what);
  Length guard = permit->guard;
  Order order = order_of(force_N, 1, speed_m_s);
  if (plausible_ && !search) {
    const WatchFigures& f = plausible_->figures();
    const double felt_N = force_N - (rest_ ? rest_->force_N() : 0);
    const auto end_m = plausible_->press().furthest_m(setup_.clock.now(), felt_N, f.order_force_N,
                                                      plausible_->travel_doubt_m());
    if (end_m) guard = std::min(guard, Length::from_si(*end_m));
  }
  if (search) {
    guard = std::min(guard, Length::from_si(search->end_m));
    permit->limits.force_min = std::max(permit->limits.force_min, Force::from_si(search->least_N));
    order.either_side = true;
    const double fall_N = order.motion.force_N - search->least_N;
    order.motion.against_N = std::max(order.motion.against_N, 2 * fall_N);
  }
  auto motion =
      setup_.frame.move_until_force(Force::from_si(force_N), Velocity::from_si(speed_m_s), guard);
  auto outcome = co_await watched(order, *permit, std::move(motion), timeout_s);
  co_return outcome;
}

// Towards the specimen when the force has to grow, away from it otherwise.
Task<Result<>> Run::move_to_force(double force_N, double speed_m_s, double timeout_s) {
  const auto present = present_force();
  if (!present) co_return fail(present.error());
  Result<MotionOutcome> outcome;
  if (force_N >= *present) {
    outcome = co_await press_until(force_N, speed_m_s, timeout_s, std::nullopt);
  } else {
    const Permit permit = pressing_->away(pressing_state());
    const Order order = order_of(force_N, -1, speed_m_s);
    auto motion = setup_.frame.move_until_force(
        Force::from_si(force_N), Velocity::from_si(-speed_m_s), permit.limits.travel_min);
    outcome = co_await watched(order, permit, std::move(motion), timeout_s);
  }
  if (!outcome) co_return fail(outcome.error());
  co_return Result<>();
}

Task<Result<>> Run::ramp_to_force(double force_N, double rate_N_s, double timeout_s) {
  const auto present = present_force();
  if (!present) co_return fail(present.error());
  auto permit = pressing_->ramp(pressing_state(), force_N, rate_N_s);
  if (!permit) co_return fail(permit.error().code, "step {}: {}", step_->id, permit.error().what);
  Order order = order_of(force_N, 0, 0);
  order.motion.rate_N_s = rate_N_s;
  if (const auto& loop = setup_.frame.capabilities().force_loop) {
    order.motion.speed_m_s = loop->approach.si();
    order.waver_N = loop->ripple.si() + rate_N_s * to_seconds(loop->lag);
    order.motion.waver_N = order.waver_N;
  }
  auto motion = setup_.frame.ramp_force(Force::from_si(force_N), ForceRate::from_si(rate_N_s));
  auto outcome = co_await watched(order, *permit, std::move(motion), timeout_s);
  if (!outcome) co_return fail(outcome.error());
  held_force_N_ = force_N;
  co_return Result<>();
}

Task<Result<Rest>> Run::watch_rest(Duration at_least) {
  watched_rest_.emplace();
  const MonoTime begin = setup_.clock.now();
  const auto enough = [&] { return watched_rest_->forces() >= kRestSamples; };
  co_await setup_.clock.wait_for(at_least);
  while (!enough() && setup_.clock.now() - begin < kLifeTime) {
    co_await setup_.clock.wait_for(50ms);
  }
  Rest rest = *std::exchange(watched_rest_, std::nullopt);
  wavers_N_ = rest.scatter_N();
  if (rest.forces() == 0) {
    const std::string place = step_ != nullptr ? "step " + step_->id + ": " : std::string();
    co_return fail(Errc::no_reply, "{}the frame sends no force", place);
  }
  co_return rest;
}

Task<Result<Rest>> Run::living_rest() {
  auto rest = co_await watch_rest(kRestTime);
  if (rest && !rest->is_alive()) rest = co_await watch_rest(kLifeTime);
  if (!rest || rest->is_alive()) co_return rest;
  co_return fail(Errc::refused,
                 "step {}: the load cell shows {:.4f} N in all of {} samples: it is frozen or not "
                 "connected, and nothing is approached with it",
                 step_->id, rest->force_N(), rest->forces());
}

// Before anything moves: whether the frame stands, and where.
Task<Result<>> Run::look_at_rest() {
  auto rest = co_await watch_rest(kRestTime);
  if (!rest) co_return fail(rest.error());
  event(rest->event<EventKind::rest>());
  if (!rest->stands()) {
    co_return fail(Errc::busy, "the frame moves, and nobody here told it to: stop whoever does");
  }
  const BoundLimits& limits = guard_.limits();
  const double force_N = rest->force_N();
  if (!setup_.continues && (force_N < limits.force_min_N || force_N > limits.force_max_N)) {
    co_return fail(
        Errc::limit_tripped,
        "the load cell shows {:.4f} N before anything was moved, the limits are {:.4g} to "
        "{:.4g} N: unload it, or zero it at the machine",
        force_N, limits.force_min_N, limits.force_max_N);
  }
  if (!setup_.continues) {
    learn_rest(*rest);
  } else if (plausible_) {
    learn_scatter(*rest);
  }
  if (plausible_) plausible_->stand(setup_.clock.now());
  start_travel_m_ = rest->travel_m();
  if (setup_.start_gap_m && start_travel_m_) {
    place_contact(*start_travel_m_ + *setup_.start_gap_m, 0);
  }
  co_return Result<>();
}

}  // namespace lcrig
