// SPDX-License-Identifier: Apache-2.0
// The way to contact: an approach in legs, so that the drift of the cell is not taken for a force.
#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <cmath>
#include <utility>

#include "protocols/run/run.hpp"

namespace lcrig {

namespace {

using namespace asio::experimental::awaitable_operators;
using namespace std::chrono_literals;

constexpr double kDriftOfThreshold = 0.25;  // so much of it a leg may drift away
constexpr Duration kDriftTime = 3s;  // a look that tells a drift well
constexpr Duration kLeastLeg = 1s;
// The scatter that the plan saw was an estimate of few samples.
constexpr double kScatterGrown = 1.5;

}  // namespace

// With slow_down: the same arithmetic as in the plan.
double Run::search_speed(const FindContactStep& step, const Rest& rest) const {
  const Environment& env = setup_.environment;
  const double v = env.get(step.speed), rise = env.get(step.force);
  if (!step.slow_down) return v;
  const double room = guard_.force_max_N() - rest.force_N() - rise;
  const double fastest = pressing_->forecast().fastest_m_s(rise, rise + 0.5 * room);
  return std::max(std::min(v, fastest), std::min(v, setup_.frame.capabilities().speed_min.si()));
}

// Of a cell that is alive; a drift that shows is looked at for longer.
Task<Result<Rest>> Run::drifting_rest() {
  auto rest = co_await living_rest();
  const bool drifts = rest && std::abs(rest->drift_N_s()) > kSureOfDrift * rest->drift_error_N_s();
  if (drifts) rest = co_await watch_rest(kDriftTime);
  co_return rest;
}

Task<Result<Rest>> Run::rest_before(const FindContactStep& step) {
  auto rest = co_await drifting_rest();
  if (!rest) co_return rest;
  if (is_loaded(rest->force_N() - zero_doubt_N())) {
    co_return fail(Errc::limit_tripped,
                   "step {}: the cell shows {:.4f} N, and {:.4f} N when nothing pressed: the probe "
                   "touches already; move it away first",
                   step_->id, rest->force_N(), rest_->force_N());
  }
  const double rise = setup_.environment.get(step.force), noise = rest->scatter_N();
  if (kScatterGrown * rise < kContactSigmas * noise) {
    co_return fail(Errc::invalid_request,
                   "step {}: contact at {:.3g} N, but the load cell scatters by {:.3g} N (standard "
                   "deviation) while it rests: at least {:.3g} N is needed",
                   step_->id, rise, noise, kContactSigmas * noise);
  }
  learn_rest(*rest);
  guard_.set_rest_force(rest->force_N(), rest->scatter_N());
  co_return rest;
}

double Run::search_end_m(const FindContactStep& step) const {
  const Environment& env = setup_.environment;
  double longest = search_speed(step, *rest_) * env.get(step.timeout);
  if (step.within) longest = std::min(longest, env.get(*step.within));
  return memory_.travel_m.value_or(0) + longest;
}

// One approach; nullopt: the cell has drifted so far that it has to be looked at again.
Task<Result<std::optional<MotionOutcome>>> Run::approach(const FindContactStep& step,
                                                         const Rest& rest, double end_m,
                                                         Duration patience) {
  const double rise = setup_.environment.get(step.force), v = search_speed(step, rest);
  const double drift = std::abs(rest.drift_N_s());
  const bool drifts = rest.drifts();
  const Duration leg =
      drifts ? std::max<Duration>(from_seconds(kDriftOfThreshold * rise / drift), kLeastLeg)
             : patience + 1s;
  const Search limits(end_m, rest.force_N() - rise);
  auto press = press_until(rest.force_N() + rise, v, to_seconds(patience), limits);
  auto r = co_await (std::move(press) || setup_.clock.wait_for(leg));
  if (r.index() == 0) {
    auto& outcome = std::get<0>(r);
    if (!outcome) co_return fail(outcome.error());
    co_return std::optional(std::move(*outcome));
  }
  co_await stop_frame();
  if (!standing_) {
    co_return fail(Errc::not_standing, "step {}: standstill not confirmed: use the E-stop",
                   step_->id);
  }
  co_return std::optional<MotionOutcome>();
}

// What is felt beyond the drift since `rest` was seen `ago`; what the drift explains is none.
double Run::felt_beyond_drift_N(const Rest& rest, const Rest& now, Duration ago) {
  const double s = to_seconds(ago);
  const double felt_N = now.force_N() - rest.force_N() - rest.drift_N_s() * s;
  const double doubt_N =
      kSureOfDrift * (std::hypot(rest.error_N(), now.error_N()) + rest.drift_error_N_s() * s);
  return std::abs(felt_N) > doubt_N ? felt_N : 0;
}

// Touched, at a force of `rest` and the threshold. `rest` is what the cell would show there
// without.
Task<Result<MotionOutcome>> Run::search(const FindContactStep& step, Rest& rest, double end_m,
                                        MonoTime deadline) {
  const double rise = setup_.environment.get(step.force);
  const double from_m = memory_.travel_m.value_or(0);
  for (;;) {
    if (rest.force_N() + rise > guard_.force_max_N()) {
      co_return fail(Errc::limit_tripped,
                     "step {}: the cell shows {:.4f} N at rest, {:.4f} N more is beyond the limit "
                     "of {:.4f} N: zero the force first",
                     step_->id, rest.force_N(), rise, guard_.force_max_N());
    }
    const MonoTime begun = setup_.clock.now();
    auto touched = co_await approach(step, rest, end_m, std::max<Duration>(deadline - begun, 1s));
    if (!touched && touched.error().code == Errc::limit_tripped) {
      co_return fail(Errc::limit_tripped, "{}; the search was to go {:.4g} mm at most",
                     touched.error().what, (end_m - from_m) * 1e3);
    }
    if (!touched) co_return fail(touched.error());
    if (*touched) {
      auto checked = check_touched(**touched);
      co_return checked;
    }
    auto now = co_await watch_rest(kDriftTime);
    if (!now) co_return fail(now.error());
    const Duration ago = setup_.clock.now() - begun;
    event(now->event<EventKind::drift>());
    const double felt_N = felt_beyond_drift_N(rest, *now, ago);
    if (felt_N > 0) {  // it touches already, more softly than the threshold
      rest.shift(now->force_N() - felt_N - rest.force_N());
      MotionOutcome soft;
      soft.force_N = now->force_N();
      soft.travel_m = now->travel_m();
      auto checked = check_touched(std::move(soft));
      co_return checked;
    }
    rest = *now;
    learn_rest(rest, Under::perhaps_contact);
    guard_.set_rest_force(rest.force_N(), rest.scatter_N());
  }
}

Result<MotionOutcome> Run::check_touched(MotionOutcome touched) const {
  if (!touched.travel_m) {
    return fail(Errc::refused, "step {}: the frame reports no travel at contact", step_->id);
  }
  // Of a contact that was run into nobody knows where it began.
  if (pressing_->broken()) {
    return fail(Errc::limit_tripped, "step {}: {}", step_->id, *pressing_->broken());
  }
  return touched;
}

}  // namespace lcrig
