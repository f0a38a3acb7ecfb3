// SPDX-License-Identifier: Apache-2.0
#include "protocols/contact/contact_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/either.hpp"
#include "protocols/contact/contact_probe.hpp"
#include "protocols/rig/forecast.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/run_parts.hpp"
#include "protocols/steps/find_contact.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

}  // namespace

ContactSearch::ContactSearch(RunParts& run, const FindContactStep& step)
    : run_(run), step_(step), rise_N_(run.get(step.force)) {}

Task<Result<>> ContactSearch::find(std::optional<double>& start_travel_m) {
  // A search that begins again may touch already, and its force would be taken for that at rest. So
  // it first goes back to its start.
  if (start_travel_m && run_.rig.frame.seen.travel_m.value_or(0) > *start_travel_m) {
    auto back = co_await return_to(*start_travel_m);
    if (!back) co_return back;
  }
  auto seen = co_await look_before();
  if (!seen) co_return seen;
  if (!start_travel_m) start_travel_m = run_.rig.frame.seen.travel_m;
  end_m_ = furthest_m();
  deadline_ = run_.setup.clock.now() + from_seconds(run_.get(step_.timeout));
  run_.watch.search_from(start_travel_m);
  for (int attempt = 0; attempt < kAttempts.count(); ++attempt) {
    const MonoTime begun = run_.setup.clock.now();
    const RestMeasurement first = rest_;
    auto touched = co_await search();
    if (!touched) co_return fail(touched.error());
    ContactProbe probe(run_, rest_, rise_N_);
    auto stepped = co_await probe.step_back(*touched->travel_m);
    if (!stepped) co_return stepped;
    if (probe.is_contact()) co_return co_await take_contact(*touched, probe);
    run_.event(NoContactEvent{*touched->travel_m, probe.touched_N(), rest_.force_N()});
    auto obeys = co_await check_obeys(probe);
    if (!obeys) co_return obeys;
    auto again = co_await look_again(begun, first);
    if (!again) co_return again;
  }
  co_return fail(Errc::refused,
                 "step {}: the force changed {} times by what contact should be, and not back on "
                 "the way back: the load cell drifts, the frame hunts, or something else pushes it",
                 run_.log.step_id(), kAttempts.count());
}

Task<Result<>> ContactSearch::return_to(double travel_m) {
  auto moved =
      co_await run_.motions.to_travel(travel_m, run_.get(step_.speed), run_.get(step_.timeout));
  co_return moved;
}

// Looks at the cell at rest. It must be alive: its last digits change. A cell that drifts is
// watched longer.
Task<Result<>> ContactSearch::look_before() {
  auto rest = co_await run_.meter.measure_alive();
  const bool drifts = rest && std::abs(rest->drift_N_s()) > kBoundSigmas * rest->drift_error_N_s();
  if (drifts) rest = co_await run_.meter.measure(kDriftTime_s.duration());
  if (!rest) co_return fail(rest.error());
  if (run_.rig.is_loaded(rest->force_N() - run_.rig.zero_uncertainty_N())) {
    co_return fail(Errc::limit_tripped,
                   "step {}: the cell shows {:.4f} N, and {:.4f} N when nothing pressed: the probe "
                   "touches already; move it away first",
                   run_.log.step_id(), rest->force_N(), run_.rig.cell.zero_N());
  }
  const double noise = rest->scatter_N();
  if (kNoiseGrown * rise_N_ < kNoiseSigmas * noise) {
    co_return fail(Errc::invalid_request,
                   "step {}: contact at {:.3g} N, but the load cell scatters by {:.3g} N (standard "
                   "deviation) while it rests: at least {:.3g} N is needed",
                   run_.log.step_id(), rise_N_, noise, kNoiseSigmas * noise);
  }
  run_.watch.learn_zero(*rest);
  rest_ = *rest;
  co_return Result<>();
}

// A cell that drifts shows it at rest, too. Where it does not, a force that rises on the way back
// is that of a drive which presses. Once it may have been a knock.
Task<Result<>> ContactSearch::check_obeys(const ContactProbe& probe) {
  if (!probe.rose()) co_return Result<>();
  co_await run_.setup.clock.wait_for(shown_after(run_.setup.frame.capabilities()));
  auto rest = co_await run_.meter.measure(kDriftTime_s.duration());
  if (!rest) co_return fail(rest.error());
  const double rose_N = probe.rose_beyond_N(*rest);
  if (rose_N <= 0) co_return Result<>();
  // No single motion away may show so much either.
  const bool surely = rose_N > run_.rig.order_now(-1, 0, run_.meter.noise_N()).against_N;
  if (++rises_ < kTwice.count() && !surely) co_return Result<>();
  co_return disbelieve_drive(probe.why_rose());
}

Result<> ContactSearch::disbelieve_drive(const std::string& seen) const {
  const std::string why = fmt::format(
      "the force rises against the command, on the way back from where the search stopped ({}), "
      "and at rest it does not",
      seen);
  run_.response.act(Doubt::drive, Response::lock_out, why);
  return fail(run_.drive.may_move().error());
}

Task<Result<>> ContactSearch::look_again(MonoTime begun, const RestMeasurement& first) {
  auto rest = co_await run_.meter.measure_alive();
  if (!rest) co_return fail(rest.error());
  rest->know_drift(first, run_.setup.clock.now() - begun);
  run_.watch.learn_zero(*rest, FrameWatch::Under::perhaps_contact);
  rest_ = *rest;
  co_return Result<>();
}

double ContactSearch::speed_m_s() const {
  return step_.search_speed_m_s(run_.values, *run_.rig.forecast,
                                run_.rig.force_max_N() - rest_.force_N() - rise_N_,
                                run_.setup.frame.capabilities().speed_min.si());
}

double ContactSearch::furthest_m() const {
  double longest = speed_m_s() * run_.get(step_.timeout);
  if (step_.within) longest = std::min(longest, run_.get(*step_.within));
  return run_.rig.frame.seen.travel_m.value_or(0) + longest;
}

// Approaches in legs until the force exceeds that of `rest_` by the threshold.
Task<Result<MotionOutcome>> ContactSearch::search() {
  const double from_m = run_.rig.frame.seen.travel_m.value_or(0);
  for (;;) {
    if (rest_.force_N() + rise_N_ > run_.rig.force_max_N()) {
      co_return fail(Errc::limit_tripped,
                     "step {}: the cell shows {:.4f} N at rest, {:.4f} N more is beyond the limit "
                     "of {:.4f} N: zero the force first",
                     run_.log.step_id(), rest_.force_N(), rise_N_, run_.rig.force_max_N());
    }
    const MonoTime begun = run_.setup.clock.now();
    auto touched = co_await approach();
    if (!touched && touched.error().code == Errc::limit_tripped) {
      co_return fail(Errc::limit_tripped, "{}; the search was to go {:.4g} mm at most",
                     touched.error().what, (end_m_ - from_m) * 1e3);
    }
    if (touched && !*touched) touched = co_await look_between(begun);
    if (!touched) co_return fail(touched.error());
    if (!*touched) continue;
    if (auto checked = check_touched(**touched); !checked) co_return fail(checked.error());
    co_return std::move(**touched);
  }
}

// One leg. nullopt: the cell may have drifted so far that it has to be looked at again.
Task<Result<std::optional<MotionOutcome>>> ContactSearch::approach() {
  const Duration patience = std::max<Duration>(deadline_ - run_.setup.clock.now(), 1s);
  const double drift_N_s = std::abs(rest_.drift_N_s());
  Duration leg = patience + 1s;
  if (rest_.drifts()) {
    leg = std::max<Duration>(from_seconds(kDriftOfThreshold * rise_N_ / drift_N_s),
                             kLeastLeg_s.duration());
  }
  const Motions::Search limits(end_m_, rest_.force_N() - rise_N_);
  auto press = run_.motions.press_until(rest_.force_N() + rise_N_, speed_m_s(),
                                        to_seconds(patience), limits);
  auto r = co_await either(std::move(press), run_.setup.clock.wait_for(leg));
  if (r.index() == 0) {
    auto& outcome = std::get<0>(r);
    if (!outcome) co_return fail(outcome.error());
    co_return std::optional(std::move(*outcome));
  }
  co_await run_.drive.stop();
  if (!run_.drive.standing()) {
    co_return fail(Errc::not_standing, "step {}: standstill not confirmed: use the E-stop",
                   run_.log.step_id());
  }
  co_return std::optional<MotionOutcome>();
}

// After a leg that found nothing. The probe may touch already, with less than the threshold.
// nullopt: it does not, and the next leg begins.
Task<Result<std::optional<MotionOutcome>>> ContactSearch::look_between(MonoTime begun) {
  auto now = co_await run_.meter.measure(kDriftTime_s.duration());
  if (!now) co_return fail(now.error());
  const Duration ago = run_.setup.clock.now() - begun;
  run_.event(now->event<EventKind::drift>());
  const double felt_N = felt_beyond_drift_N(*now, ago);
  if (felt_N > 0) {
    rest_.shift(now->force_N() - felt_N - rest_.force_N());
    MotionOutcome soft;
    soft.force_N = now->force_N();
    soft.travel_m = now->travel_m();
    co_return std::optional(std::move(soft));
  }
  rest_ = *now;
  run_.watch.learn_zero(rest_, FrameWatch::Under::perhaps_contact);
  co_return std::optional<MotionOutcome>();
}

// The force beyond the drift since `rest_` was measured, `ago`. A force that drift and noise
// explain counts as zero.
double ContactSearch::felt_beyond_drift_N(const RestMeasurement& now, Duration ago) const {
  const double s = to_seconds(ago);
  const double felt_N = now.force_N() - rest_.force_N() - rest_.drift_N_s() * s;
  const double doubt_N =
      kBoundSigmas * (std::hypot(rest_.error_N(), now.error_N()) + rest_.drift_error_N_s() * s);
  return std::abs(felt_N) > doubt_N ? felt_N : 0;
}

Result<> ContactSearch::check_touched(const MotionOutcome& touched) const {
  const std::string& step = run_.log.step_id();
  if (!touched.travel_m) {
    return fail(Errc::refused, "step {}: the frame reports no travel at contact", step);
  }
  // After an overrun the place of contact is unknown.
  const auto may = run_.rig.trust.may_press();
  if (!may) return fail(may.error().code, "step {}: {}", step, may.error().what);
  return {};
}

// Stores the place and the stiffness of the contact that was found.
Task<Result<>> ContactSearch::take_contact(const MotionOutcome& touched,
                                           const ContactProbe& probe) {
  const double felt_N = touched.force_N.value_or(probe.touched_N()) - rest_.force_N();
  // If it rose on a way back before, it is not the cell that is reversed.
  if (felt_N < 0 && rises_ > 0) {
    co_return disbelieve_drive(
        fmt::format("{:.4f} N after {:.4f} N", rest_.force_N(), felt_N + rest_.force_N()));
  }
  if (auto real = probe.check_felt(felt_N); !real) co_return real;
  run_.watch.search_from(std::nullopt);
  run_.watch.place_contact(*touched.travel_m, std::max(felt_N, rise_N_));
  run_.event(ContactEvent{*touched.travel_m, touched.force_N.value_or(0), rest_.force_N()});
  auto moved = co_await return_to(*touched.travel_m - run_.get(step_.back_off));
  if (!moved) co_return moved;
  const Duration settles = settles_after(run_.setup.frame.capabilities());
  if (settles > Duration::zero()) co_await run_.setup.clock.wait_for(settles);
  auto after = co_await run_.meter.measure(kLook_s.duration());
  if (!after) co_return fail(after.error());
  const RestMeasurement& bare = probe.off_contact(*after);
  run_.watch.know_depth(probe.depth_m());
  if (probe.presses(bare)) {
    const double back_m = run_.get(step_.back_off);
    co_return fail(Errc::invalid_request,
                   "step {}: back_off_mm is too small: {:.3g} mm back from where the force had "
                   "risen by {:.3g} N, the probe still presses with about {:.3g} N; state at least "
                   "{:.2g} mm",
                   run_.log.step_id(), back_m * 1e3, felt_N, after->force_N() - rest_.force_N(),
                   probe.depth_m() * 1e3);
  }
  probe.conclude_stiffness(bare, speed_m_s());
  run_.watch.learn_zero(bare);  // the zero may have drifted during the search
  run_.watch.learn_untouched(rest_.force_N());
  const auto start_m = run_.rig.contact.start_travel_m;
  if (!run_.setup.check_at_contact || !start_m) co_return moved;
  const double contact_m = *run_.rig.contact.travel_m + run_.rig.frame.zero_m;
  co_return co_await run_.setup.check_at_contact(*start_m, contact_m);
}

}  // namespace lcrig
