// SPDX-License-Identifier: Apache-2.0
// The search for contact: a live cell, a bounded way, and how stiff the contact is, measured on the
// first micrometres of the way back, which cannot press harder.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "protocols/run/run.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr Duration kLook = 300ms;
constexpr Duration kStillArrives = 100ms;  // samples of the motion that still arrive after its end
constexpr double kFirstStep_m = 0.2e-6;
constexpr double kFastest_m_s = 10e-6;  // of the steps back
constexpr int kSteps = 12;  // each twice as far: up to 0.8 mm
constexpr double kSlopeSigmas = 3;
constexpr double kEnough = 0.3;  // of the force at contact: less left tells no more
constexpr double kLeft = 0.1;  // ... and less than this may be none
constexpr double kMore = 1.2;  // of it: what a cell may drift meanwhile
constexpr double kLeastFelt = 0.2;  // of the threshold, once the frame stands
constexpr double kGone = 0.05;  // of the threshold or what was felt, on the way back
constexpr double kLongWay = 1.2, kLongWayMore_s = 5;  // back from where a search ended
constexpr int kAttempts = 5;  // of a search that finds what is no contact

}  // namespace

void Run::place_contact(double travel_m, double force_N) {
  if (plausible_) plausible_->press().forget();  // until its stiffness is measured
  contact_travel_m_ = travel_m;
  contact_force_N_ = force_N;
  guard_.place_contact(travel_m);
}

namespace {

// Largest and least stiffness that a drop of the force on a way back allows, and the best guess,
// N/m.
struct Slope {
  double about = 0, at_most = 0, at_least = 0;
};

std::optional<Slope> slope_of(const Rest& touched, const Rest& now, double resolution_m) {
  const double error_N = kSlopeSigmas * std::hypot(touched.error_N(), now.error_N());
  const double drop_N = touched.force_N() - now.force_N();
  if (!touched.travel_m() || !now.travel_m() || drop_N < 3 * error_N) return std::nullopt;
  const double way_m = *touched.travel_m() - *now.travel_m();
  if (way_m <= resolution_m) return std::nullopt;
  return Slope{drop_N / way_m, (drop_N + error_N) / (way_m - resolution_m),
               (drop_N - error_N) / (way_m + resolution_m)};
}

}  // namespace

// Steps back, each twice as far as the one before, as long as something of the force is left: the
// longest way in contact tells the slope best.
Task<Result<std::vector<Rest>>> Run::step_back(const MotionOutcome& contact, const Rest& before) {
  const double touched_m = *contact.travel_m;
  std::vector<Rest> looks;
  co_await setup_.clock.wait_for(kStillArrives);
  auto touched = co_await watch_rest(kLook);
  if (!touched) co_return fail(touched.error());
  looks.push_back(*touched);
  const double felt_N = touched->force_N() - before.force_N();
  const FrameCapabilities caps = frame_capabilities();
  const double speed = std::clamp(kFastest_m_s, caps.speed_min.si(), caps.speed_max.si());
  const double end_m = device_limits(guard_.limits(), caps).travel_min.si();
  double step_m = kFirstStep_m, left_N = felt_N;
  for (int i = 0;
       i < kSteps && std::abs(left_N) > kEnough * std::abs(felt_N) && touched_m - step_m > end_m;
       ++i, step_m *= 2) {
    auto moved = co_await move_to_travel(touched_m - step_m, speed, 60 + step_m / speed);
    if (!moved) co_return fail(moved.error());
    co_await setup_.clock.wait_for(kStillArrives);
    auto now = co_await watch_rest(kLook);
    if (!now) co_return fail(now.error());
    left_N = now->force_N() - before.force_N();
    looks.push_back(*now);
    // A contact never presses harder on the way back: this is none.
    if (std::abs(left_N) > kMore * std::abs(felt_N) + kContactSigmas * now->error_N()) break;
  }
  co_return looks;
}

// Whether what was felt is gone, or grew less, where the probe went away: a force that stays is
// none of a specimen, and noise is none.
bool Run::is_contact(const std::vector<Rest>& looks, const Rest& before, double rise_N) {
  const Rest& touched = looks.front();
  const double felt_N = touched.force_N() - before.force_N();
  if (std::abs(felt_N) < kLeastFelt * rise_N) return false;
  const double fallen_N = std::copysign(1, felt_N) * (touched.force_N() - looks.back().force_N());
  const double doubt_N = 2 * kSlopeSigmas * std::hypot(touched.error_N(), looks.back().error_N());
  return fallen_N > std::max(doubt_N, kGone * std::min(std::abs(felt_N), rise_N));
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
    const double noise_N = kSlopeSigmas * std::hypot(before.error_N(), now->error_N());
    if (now->force_N() - none_N < std::max(2 * noise_N, kLeft * felt_N)) break;
    resolution.add(now->travel_m());
    const auto slope = slope_of(touched, *now, resolution.step_m());
    if (slope && (!best || slope->at_most < best->at_most)) best = slope;
  }
  StiffnessEvent measured;
  measured.force_N = touched.force_N();
  if (best) {
    measured.stiffness_N_m = best->about;
    measured.at_most_N_m = best->at_most;
    measured.at_least_N_m = best->at_least;
  }
  event(measured);
  if (!best) return;
  pressing_->measured(felt_N, best->at_most);
  if (plausible_ && touched.travel_m()) {
    plausible_->press().know(setup_.clock.now(), *touched.travel_m(), felt_N, best->at_least);
  }
}

Task<Result<>> Run::back_off(double clear_m, const FindContactStep& step, const Rest& before,
                             const std::vector<Rest>& looks) {
  const Environment& env = setup_.environment;
  auto moved = co_await move_to_travel(clear_m, env.get(step.speed), env.get(step.timeout));
  if (!moved) co_return moved;
  auto after = co_await watch_rest(kLook);
  if (!after) co_return fail(after.error());
  conclude_stiffness(looks, before, *after);
  learn_rest(*after);  // its zero may have drifted on the way
  guard_.set_rest_force(after->force_N(), after->scatter_N());
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
  auto rest = co_await rest_before(step);
  if (!rest) co_return fail(rest.error());
  if (!progress.start_travel_m) progress.start_travel_m = memory_.travel_m;
  const double end_m = search_end_m(step);
  const MonoTime deadline = setup_.clock.now() + from_seconds(env.get(step.timeout));
  searched_from_m_ = progress.start_travel_m;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const MonoTime begun = setup_.clock.now();
    const Rest first = *rest;
    auto touched = co_await search(step, *rest, end_m, deadline);
    if (!touched) co_return fail(touched.error());
    auto looks = co_await step_back(*touched, *rest);
    if (!looks) co_return fail(looks.error());
    if (is_contact(*looks, *rest, env.get(step.force))) {
      auto result = co_await take_contact(step, *touched, *rest, *looks);
      co_return result;
    }
    event(NoContactEvent{*touched->travel_m, looks->front().force_N(), rest->force_N()});
    rest = co_await living_rest();
    if (!rest) co_return fail(rest.error());
    rest->know_drift(first, setup_.clock.now() - begun);
    learn_rest(*rest, Under::perhaps_contact);
  }
  co_return fail(Errc::refused,
                 "step {}: the force changed {} times by what contact should be, and not back on "
                 "the way back: the load cell drifts, the frame hunts, or something else pushes it",
                 step_->id, kAttempts);
}

// Where the specimen is, and what it is like there.
Task<Result<>> Run::take_contact(const FindContactStep& step, const MotionOutcome& touched,
                                 const Rest& rest, const std::vector<Rest>& looks) {
  const Environment& env = setup_.environment;
  const double felt_N = touched.force_N.value_or(looks.front().force_N()) - rest.force_N();
  double least_N = looks.front().scatter_N();
  for (const Rest& look : looks) least_N = std::min(least_N, look.scatter_N());
  const double wavers_N = kContactSigmas * std::max(rest.scatter_N(), least_N);
  if (felt_N < 0 && -felt_N < wavers_N) {
    co_return fail(Errc::refused,
                   "step {}: where the probe touches the force wavers by {:.3g} N (standard "
                   "deviation), more than contact at {:.3g} N tells: does the frame hunt?",
                   step_->id, least_N, env.get(step.force));
  }
  if (felt_N < 0) {
    const std::string why = fmt::format(
        "the force falls where the probe presses ({:.4f} N, {:.4f} N at rest), and rises on the "
        "way back: the load cell is connected the wrong way",
        rest.force_N() + felt_N, rest.force_N());
    disbelieve(Contradiction(Disbelief::force, why));
    co_return fail(Errc::refused, "step {}: {}", step_->id, why);
  }
  searched_from_m_.reset();
  place_contact(*touched.travel_m, std::max(felt_N, env.get(step.force)));
  event(ContactEvent{*contact_travel_m_, touched.force_N.value_or(0), rest.force_N()});
  const double clear_m = *contact_travel_m_ - env.get(step.back_off);
  auto result = co_await back_off(clear_m, step, rest, looks);
  co_return result;
}

// `finally` asks for a gap, and contact was never found. What presses all the same is left by the
// same way, from here; a force that nobody knows counts as one that presses.
// A search that found nothing may have pressed with a cell that did not show it: it goes back to
// where it began. The place is chosen once, however often the frame is lost on the way.
Task<Result<>> Run::back_away(const Target& to, double speed_m_s, double timeout_s,
                              StepProgress& progress) {
  const auto force = present_force();
  const bool presses = !force || guard_.is_distrusted() || is_loaded(*force);
  if (!progress.away_m && !presses && !searched_from_m_) {
    event(EventKind::skipped,
          "no contact was found, and nothing presses: there is nothing to move away from");
    co_return Result<>();
  }
  if (!memory_.travel_m) {
    co_return fail(Errc::no_reply, "step {}: the frame sends no travel", step_->id);
  }
  const double here_m = *memory_.travel_m;
  if (!progress.away_m) {
    const double least = device_limits(guard_.limits(), frame_capabilities()).travel_min.si();
    double target_m = presses ? here_m - setup_.environment.get(to.value) : here_m;
    if (searched_from_m_) target_m = std::min(target_m, *searched_from_m_);
    progress.away_m = std::max(least, target_m);
  }
  if (*progress.away_m >= here_m) co_return Result<>();
  const double way_s = (here_m - *progress.away_m) / speed_m_s;
  auto moved = co_await move_to_travel(*progress.away_m, speed_m_s,
                                       std::max(timeout_s, kLongWay * way_s + kLongWayMore_s));
  co_return moved;
}

}  // namespace lcrig
