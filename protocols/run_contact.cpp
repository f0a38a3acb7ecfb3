// SPDX-License-Identifier: Apache-2.0
// The search for contact: a live cell, a bounded way, and how stiff the contact is, measured on the
// first micrometres of the way back, which cannot press harder.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "protocols/run.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr Duration kLook = 300ms;
constexpr double kFirstStep_m = 0.2e-6;
constexpr double kFastest_m_s = 10e-6;  // of the steps back
constexpr int kSteps = 12;  // each twice as far: up to 0.8 mm
constexpr double kSigmas = 3;
constexpr double kEnough = 0.3;  // of the force at contact: less left tells no more
constexpr double kLeft = 0.1;  // ... and less than this may be none

}  // namespace

void Run::place_contact(double travel_m, double force_N) {
  contact_travel_m_ = travel_m;
  contact_force_N_ = force_N;
  guard_.place_contact(travel_m);
}

// With slow_down: the same arithmetic as in the plan.
double Run::search_speed(const FindContactStep& step, const Rest& rest) const {
  const Environment& env = setup_.environment;
  const double v = env.get(step.speed), rise = env.get(step.force);
  if (!step.slow_down) return v;
  const double room = guard_.force_max_N() - rest.force_N() - rise;
  const double fastest = pressing_->forecast().fastest_m_s(rise, rise + 0.5 * room);
  return std::max(std::min(v, fastest), std::min(v, setup_.frame.capabilities().speed_min.si()));
}

Task<Result<MotionOutcome>> Run::search(const FindContactStep& step, const Rest& rest) {
  const Environment& env = setup_.environment;
  const double rise = env.get(step.force), v = search_speed(step, rest);
  if (rest.force_N() + rise > guard_.force_max_N()) {
    co_return fail(Errc::limit_tripped,
                   "step {}: the cell shows {:.4f} N at rest, {:.4f} N more is beyond the limit of "
                   "{:.4f} N: zero the force first",
                   step_->id, rest.force_N(), rise, guard_.force_max_N());
  }
  double longest = v * env.get(step.timeout);
  if (step.within) longest = std::min(longest, env.get(*step.within));
  const double end = memory_.travel_m.value_or(0) + longest;
  auto outcome = co_await press_until(rest.force_N() + rise, v, env.get(step.timeout), end);
  if (!outcome && outcome.error().code == Errc::limit_tripped) {
    co_return fail(Errc::limit_tripped, "{}; the search was to go {:.4g} mm at most",
                   outcome.error().what, longest * 1e3);
  }
  co_return outcome;
}

namespace {

// Largest stiffness that a drop of the force on a way back allows, and the best guess, N/m.
struct Slope {
  double about = 0, at_most = 0;
};

std::optional<Slope> slope_of(const Rest& touched, const Rest& now, double resolution_m) {
  const double error_N = kSigmas * std::hypot(touched.error_N(), now.error_N());
  const double drop_N = touched.force_N() - now.force_N();
  if (!touched.travel_m() || !now.travel_m() || drop_N < 3 * error_N) return std::nullopt;
  const double way_m = *touched.travel_m() - *now.travel_m();
  if (way_m <= resolution_m) return std::nullopt;
  return Slope{drop_N / way_m, (drop_N + error_N) / (way_m - resolution_m)};
}

}  // namespace

// Steps back, each twice as far as the one before, as long as something of the force is left: the
// longest way in contact tells the slope best.
Task<Result<std::vector<Rest>>> Run::step_back(double touched_m, const Rest& before) {
  std::vector<Rest> looks;
  auto touched = co_await watch_rest(kLook);
  if (!touched) co_return fail(touched.error());
  looks.push_back(*touched);
  const double felt_N = touched->force_N() - before.force_N();
  const FrameCapabilities caps = frame_capabilities();
  const double speed = std::clamp(kFastest_m_s, caps.speed_min.si(), caps.speed_max.si());
  const double end_m = device_limits(guard_.limits(), caps).travel_min.si();
  double step_m = kFirstStep_m, left_N = felt_N;
  for (int i = 0; i < kSteps && left_N > kEnough * felt_N && touched_m - step_m > end_m;
       ++i, step_m *= 2) {
    auto moved = co_await move_to_travel(touched_m - step_m, speed, 60 + step_m / speed);
    if (!moved) co_return fail(moved.error());
    auto now = co_await watch_rest(kLook);
    if (!now) co_return fail(now.error());
    left_N = now->force_N() - before.force_N();
    looks.push_back(*now);
  }
  co_return looks;
}

// `looks`: at contact, and after each step back. A step on whose way contact was lost would tell of
// a contact that is softer than it is: what is left must be more than the cell shows without any,
// before and afterwards, for its zero may have drifted meanwhile.
void Run::conclude_stiffness(const std::vector<Rest>& looks, const Rest& before,
                             const Rest& after) {
  const Rest& touched = looks.front();
  const double felt_N = touched.force_N() - before.force_N();
  const double none_N = std::max(before.force_N(), after.force_N());
  TravelStep resolution;
  std::optional<Slope> best;
  for (auto now = looks.begin() + 1; now != looks.end(); ++now) {
    const double noise_N = kSigmas * std::hypot(before.error_N(), now->error_N());
    if (now->force_N() - none_N < std::max(2 * noise_N, kLeft * felt_N)) break;
    resolution.add(now->travel_m());
    const auto slope = slope_of(touched, *now, resolution.step_m());
    if (slope && (!best || slope->at_most < best->at_most)) best = slope;
  }
  const auto number = [](std::optional<double> v) { return v ? fmt::format("{}", *v) : "null"; };
  event("stiffness",
        fmt::format(R"({{"force_N":{},"stiffness_N_m":{},"at_most_N_m":{}}})", touched.force_N(),
                    number(best ? std::optional(best->about) : std::nullopt),
                    number(best ? std::optional(best->at_most) : std::nullopt)));
  if (best) pressing_->measured(felt_N, best->at_most);
}

Task<Result<>> Run::back_off(double clear_m, const FindContactStep& step, const Rest& before,
                             const std::vector<Rest>& looks) {
  const Environment& env = setup_.environment;
  auto moved = co_await move_to_travel(clear_m, env.get(step.speed), env.get(step.timeout));
  if (!moved) co_return moved;
  auto after = co_await watch_rest(kLook);
  if (!after) co_return fail(after.error());
  conclude_stiffness(looks, before, *after);
  if (!setup_.check_at_contact || !start_travel_m_) co_return moved;
  auto possible =
      co_await setup_.check_at_contact(*start_travel_m_, *contact_travel_m_ + travel_zero_m_);
  co_return possible;
}

Task<Result<>> Run::execute(const FindContactStep& step, StepProgress& progress) {
  const Environment& env = setup_.environment;
  aim_at(std::nullopt);
  // A search that begins again may already touch: what it would take for the force at rest is not.
  if (progress.start_travel_m && memory_.travel_m.value_or(0) > *progress.start_travel_m) {
    auto back = co_await move_to_travel(*progress.start_travel_m, env.get(step.speed),
                                        env.get(step.timeout));
    if (!back) co_return back;
  }
  auto rest = co_await living_rest();
  if (!rest) co_return fail(rest.error());
  if (is_loaded(rest->force_N() - zero_doubt_N())) {
    co_return fail(Errc::limit_tripped,
                   "step {}: the cell shows {:.4f} N, and {:.4f} N when nothing pressed: the probe "
                   "touches already; move it away first",
                   step_->id, rest->force_N(), rest_->force_N());
  }
  rest_ = *rest;
  guard_.set_rest_force(rest->force_N(), rest->scatter_N());
  if (!progress.start_travel_m) progress.start_travel_m = memory_.travel_m;
  auto touched = co_await search(step, *rest);
  if (!touched) co_return fail(touched.error());
  if (!touched->travel_m) {
    co_return fail(Errc::refused, "step {}: the frame reports no travel at contact", step_->id);
  }
  // Of a contact that was run into nobody knows where it began.
  if (pressing_->broken()) {
    co_return fail(Errc::limit_tripped, "step {}: {}", step_->id, *pressing_->broken());
  }
  const double felt_N = touched->force_N.value_or(force_N_.value_or(0)) - rest->force_N();
  place_contact(*touched->travel_m, std::max(felt_N, env.get(step.force)));
  event("contact", fmt::format(R"({{"travel_m":{},"force_N":{},"rest_force_N":{}}})",
                               *contact_travel_m_, touched->force_N.value_or(0), rest->force_N()));
  auto looks = co_await step_back(*contact_travel_m_, *rest);
  if (!looks) co_return fail(looks.error());
  const double clear_m = *contact_travel_m_ - env.get(step.back_off);
  auto result = co_await back_off(clear_m, step, *rest, *looks);
  co_return result;
}

// `finally` asks for a gap, and contact was never found. What presses all the same is left by the
// same way, from here; a force that nobody knows counts as one that presses.
Task<Result<>> Run::back_away(const Target& to, double speed_m_s, double timeout_s) {
  const auto force = present_force();
  if (force && !guard_.is_distrusted() && !is_loaded(*force)) {
    event("skipped",
          "no contact was found, and nothing presses: there is nothing to move away from");
    co_return Result<>();
  }
  if (!memory_.travel_m) {
    co_return fail(Errc::no_reply, "step {}: the frame sends no travel", step_->id);
  }
  const double least = device_limits(guard_.limits(), frame_capabilities()).travel_min.si();
  const double target_m = std::max(least, *memory_.travel_m - setup_.environment.get(to.value));
  auto moved = co_await move_to_travel(target_m, speed_m_s, timeout_s);
  co_return moved;
}

}  // namespace lcrig
