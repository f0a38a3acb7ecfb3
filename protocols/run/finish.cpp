// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/finish.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "base/either.hpp"
#include "base/text.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/losses.hpp"
#include "protocols/run/run_parts.hpp"
#include "protocols/run/take_over.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr double kClear_m = 20e-6;  // above the specimen; nothing should press from there on
constexpr double kFarClear_m = 100e-6;  // above the specimen; certainly nothing presses there
constexpr std::string_view kUnknown =
    "whether the specimen is still loaded is not known: look at the rig, drive the frame away from "
    "it at the machine";

}  // namespace

void Finish::fail_with(Errc code, std::string_view why) {
  if (ended_well(result_.exit_status)) {
    result_.exit_status = ExitStatus::fail;
    result_.code = code;
  }
  add_remark(result_.reason, why);
}

void Finish::hear(const InterruptRequest& stop) {
  if (stop.hands_off) told_hands_off_ = true;
  if (stop.code == Errc::not_standing) told_standstill_ = true;
}

Task<RunResult> Finish::end(std::optional<InterruptRequest> stop) {
  if (stop && stop->code == Errc::frame_fault && run_.drive.keep_hands_off(stop->why)) {
    stop->hands_off = true;
  }
  run_.progress.enter<RunState::finishing>();
  run_.watch.expect_standstill();
  stop = run_.interrupts.begin_finish(std::move(stop));
  co_await run_.drive.stop();
  if (losses_.frame_away() != nullptr) co_await losses_.bring_frame_back();
  co_await prove_readings(stop.has_value());
  co_await stop_for(stop);
  run_.watch.start_retreat();
  const bool clears = may_clear(stop && stop->kind == Interrupt::freeze);
  if (clears) co_await run_finally();
  run_.watch.expect_standstill();
  co_await run_.drive.stop_for_good();
  tell_standstill();
  tell_hands_off(clears);
  run_.watch.end();
  run_.interrupts.expect_no_stop();
  if (run_.setup.moves() && run_.drive.prepared()) co_await tell_load();
  if (const auto& moved = run_.response.moves_again(); moved && run_.drive.standing()) {
    co_await run_.drive.stop();
    fail_with(Errc::refused, *moved + "; it was stopped again");
  }
  co_await make_meter_safe();
  run_.setup.frame.set_listener(nullptr);
  run_.interrupts.close();
  run_.progress.enter<RunState::ended>();
  result_.peak_force_N = run_.rig.course.peak_force_N;
  result_.stands = !run_.setup.moves() || !run_.drive.prepared() ||
                   (run_.drive.standing() && losses_.frame_away() == nullptr);
  co_return std::move(result_);
}

// The readings of the steps, before those of `finally`. A run that was stopped does not wait for
// it.
Task<> Finish::prove_readings(bool stopped) {
  run_.sampler.doubt();
  if (stopped || losses_.meter_away()) co_return;
  auto same = co_await run_.sampler.prove();
  if (same || same.error().code != Errc::refused) co_return;
  losses_.lose_meter(same.error());
  const bool bears = run_.setup.protocol.on_loss != OnLoss::abort;
  if (!bears) unproven_ = same.error();
}

// Takes the reason of the stop, and resynchronises the frame, because an exchange may have been
// cut.
Task<> Finish::stop_for(const std::optional<InterruptRequest>& stop) {
  result_.exit_status = ExitStatus::success;
  if (!stop && unproven_) fail_with(unproven_->code, unproven_->what);
  if (!stop) co_return;
  hear(*stop);
  if (stop->kind == Interrupt::stop_after) {  // came between two steps: no exchange was cut
    result_.exit_status = ExitStatus::stopped;
    result_.reason = stop->why;
    co_return;
  }
  const bool wanted = stop->kind == Interrupt::abort || stop->kind == Interrupt::freeze;
  result_.exit_status = wanted ? ExitStatus::abort : ExitStatus::fail;
  // The status "abort" says that word already.
  const auto kind = to_string(event_of(stop->kind));
  result_.reason =
      stop->kind == Interrupt::abort ? stop->why : fmt::format("{}: {}", kind, stop->why);
  result_.code = stop->code;
  if (run_.setup.commands) {
    auto line = co_await run_.setup.frame.resync();
    if (!line) run_.event(EventKind::retry, line.error().what);
  }
  if (run_.drive.prepared()) co_await see_standstill();
}

// Waits for samples of the standstill, because the last ones before it belong to the motion. The
// way back is allowed the force that the specimen feels now. Does not wait for a silent cell.
Task<> Finish::see_standstill() {
  Clock& clock = run_.setup.clock;
  if (!run_.setup.moves()) co_return;
  const MonoTime stood = clock.now();
  const MonoTime limit =
      stood + std::max<Duration>(500ms, from_seconds(3 / run_.setup.frame_rate_Hz));
  const auto waits = [&] {
    return run_.rig.frame.force_at <= stood && losses_.frame_away() == nullptr;
  };
  while (waits() && clock.now() < limit) co_await clock.wait_for(20ms);
}

void Finish::tell_not_run(std::string_view why) {
  told_not_run_ = true;
  add_remark(result_.reason, fmt::format("`finally` did not run: {}", why));
}

// Whether `finally` can and may run. Reports why not.
bool Finish::may_clear(bool frozen) {
  if (frozen) return false;
  if (!run_.drive.prepared() && run_.setup.commands) {
    return false;  // the run asked nothing of the frame
  }
  if (const Error* why = losses_.frame_away()) {
    if (ended_well(result_.exit_status)) {  // all steps succeeded
      result_.exit_status = ExitStatus::fail;
      result_.code = why->code;
      add_remark(result_.reason, why->what);
    }
    tell_not_run(
        "the frame is not there; standstill is not confirmed: look at it, use the E-stop if it "
        "moves");
    return false;
  }
  if (run_.drive.hands_off()) return false;  // tell_hands_off reports the reason
  if (run_.setup.moves() && !run_.drive.standing()) {
    result_.exit_status = ExitStatus::fail;
    result_.code = Errc::not_standing;
    tell_not_run("standstill not confirmed: use the E-stop, then look at the rig");
    told_standstill_ = true;
    return false;
  }
  if (take_over_.unconfirmed()) {
    tell_not_run(
        "nobody confirmed the specimen; look at it, and drive the frame "
        "away at the machine if it is loaded");
    return false;
  }
  if (run_.setup.commands && run_.rig.trust.force && run_.rig.stood_pulled()) {
    tell_not_run(
        fmt::format("the load cell shows {:.3f} N: the specimen pulls at the probe, or the zero of "
                    "the cell has moved; no way is known to be safe: look at it, free it by hand",
                    run_.rig.frame.force_N.value_or(0)));
    return false;
  }
  return true;
}

// Runs `finally`, whatever happened before. It has a deadline of its own, after which the frame
// stays where it is.
Task<> Finish::run_finally() {
  const MonoTime deadline = run_.setup.clock.now() + run_.setup.protocol.finally_timeout;
  auto r = co_await either(run_steps_(), run_.setup.clock.wait_until(deadline));
  std::string why;
  Errc code = Errc::no_reply;
  if (r.index() == 1) {
    why = fmt::format("`finally` did not end in {:.0f} s; the frame was stopped where it stood",
                      to_seconds(run_.setup.protocol.finally_timeout));
  } else if (const auto& stop = std::get<0>(r)) {
    hear(*stop);
    const bool frozen = stop->kind == Interrupt::freeze;
    why = fmt::format("in `finally`: {}{}", frozen ? "freeze: " : "", stop->why);
    code = stop->code;
  }
  if (why.empty()) co_return;
  run_.event(EventKind::fault, why);
  fail_with(code, why);
}

void Finish::tell_standstill() {
  if (!run_.setup.moves() || run_.drive.standing() || losses_.frame_away() != nullptr) return;
  result_.exit_status = ExitStatus::fail;
  result_.code = Errc::not_standing;
  if (!told_standstill_) {
    add_remark(result_.reason, "standstill not confirmed: use the E-stop");
  }
}

// Adds the fault to the run's reason, unless the reason contains it.
void Finish::tell_hands_off(bool cleared) {
  const auto& why = run_.drive.hands_off();
  if (!why) return;
  if (ended_well(result_.exit_status)) {  // all steps succeeded
    result_.exit_status = ExitStatus::fail;
    result_.code = why->code;
  }
  if (!told_hands_off_) add_remark(result_.reason, why->what);
  constexpr std::string_view kStill =
      "nothing is moved any more until a person has looked at the rig";
  if (cleared || told_not_run_) {
    add_remark(result_.reason, kStill);
  } else {
    tell_not_run(kStill);
  }
}

// Checks that the specimen is unloaded. If it is not, the run says so, and what to do.
Task<> Finish::tell_load() {
  const Duration settles = settles_after(run_.setup.frame.capabilities());
  if (run_.setup.moves() && settles > Duration::zero()) {
    co_await run_.setup.clock.wait_for(settles);
  }
  auto rest = co_await run_.meter.measure(200ms);
  const std::string why = load_left(rest);
  if (why.empty()) co_return;
  run_.event(EventKind::loaded, why);
  fail_with(Errc::limit_tripped, why);
}

// Words for a load that is left; empty: none is.
std::string Finish::load_left(const Result<RestMeasurement>& rest) const {
  const std::optional<double> contact_m = run_.rig.contact.travel_m;
  const std::optional<double> travel_m = rest ? rest->travel_m() : run_.rig.frame.seen.travel_m;
  // The search stood at the place of contact, which lies inside a specimen that it ran into.
  const double gap_m = contact_m && travel_m ? *contact_m - *travel_m : -kFarClear_m;
  const double clear_m = gap_m - run_.rig.contact.depth_m;
  const bool clear = clear_m > kClear_m;
  const bool surely = clear_m > kFarClear_m && run_.rig.contact.least;
  const bool obeys = losses_.frame_away() == nullptr && !run_.drive.hands_off();
  // Clear of the specimen, a force counts as load only beyond the error of the cell's zero.
  const double doubt_N = clear ? run_.rig.zero_uncertainty_N() : 0;
  const bool pulls = rest && run_.rig.is_pulled(rest->force_N());
  const bool loaded = rest && run_.rig.is_loaded(rest->force_N() - doubt_N);
  if (obeys && clear && !pulls && !loaded) return {};
  if (obeys && rest && surely && !pulls) {
    return fmt::format(
        "by its travel the probe is clear of the specimen, {:.3g} mm above contact, whatever the "
        "load cell shows ({:.3f} N): check its zero",
        gap_m * 1e3, rest->force_N());
  }
  if (losses_.frame_away() != nullptr || !rest || !run_.rig.trust.force) {
    return std::string(kUnknown);
  }
  if (run_.rig.is_loaded(rest->force_N())) {
    return fmt::format(
        "the specimen is still loaded with about {:.3f} N: drive the frame away from it "
        "at the machine",
        rest->force_N() - run_.rig.cell.unloaded_at_most_N());
  }
  const double felt_N = rest->force_N() - run_.rig.cell.unloaded_N();
  if (pulls) {
    return fmt::format(
        "the load cell shows about {:.3f} N less than unloaded: the specimen pulls at the probe, "
        "or the zero of the cell has moved; look at it, free it by hand before the frame is moved",
        -felt_N);
  }
  if (obeys) return {};
  return fmt::format("the specimen is not loaded, as far as the cell shows ({:.3f} N)", felt_N);
}

Task<> Finish::make_meter_safe() {
  co_await run_.sampler.stop();
  co_await run_.sampler.finish_proof();
  if (losses_.meter_away()) co_return;
  auto safe = co_await run_.setup.lcr.make_safe();
  if (!safe) run_.event(EventKind::retry, safe.error().what);
}

}  // namespace lcrig
