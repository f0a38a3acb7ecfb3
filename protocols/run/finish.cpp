// SPDX-License-Identifier: Apache-2.0
// How a run ends, whatever happened before: the frame stopped, `finally`, the meter safe, and the
// truth about what lies under the probe.
#include <fmt/format.h>

#include <boost/asio/experimental/awaitable_operators.hpp>
#include <cmath>
#include <utility>
#include <variant>

#include "protocols/file/words.hpp"
#include "protocols/run/run.hpp"

namespace lcrig {

namespace {

using namespace asio::experimental::awaitable_operators;
using namespace std::chrono_literals;

constexpr double kClear_m = 20e-6;  // this far above contact nothing should be pressed
constexpr double kFarClear_m = 100e-6;  // ... and this far above surely nothing is
constexpr std::string_view kUnknown =
    "whether the specimen is still loaded is not known: look at the rig, drive the frame away from "
    "it at the machine";
constexpr double kZeroDoubt = 1e-3;  // of the cell's nominal: what class 1 allows its zero

void fail_with(RunResult& result, Errc code, std::string_view why) {
  if (result.exit_status == ExitStatus::success) {
    result.exit_status = ExitStatus::fail;
    result.code = code;
  }
  add_note(result.reason, why);
}

}  // namespace

Task<> Run::stop_frame() {
  if (!setup_.frame.capabilities().motion || !setup_.commands) {
    standing_ = true;
    ++stands_;
    if (setup_.on_stop) setup_.on_stop();
    co_return;
  }
  if (plausible_) plausible_->look_away();
  auto stopped = co_await setup_.frame.stop();
  standing_ = stopped.has_value();
  if (plausible_ && standing_) plausible_->stand(setup_.clock.now());
  ++(standing_ ? stands_ : failed_stops_);
  if (setup_.on_stop) setup_.on_stop();
  event(stopped ? EventKind::stopped : EventKind::stop_failed, stopped ? "" : stopped.error().what);
}

// The last samples before a standstill are of the motion: the way back is allowed what the specimen
// feels now. A cell that says nothing is not waited for.
Task<> Run::see_standstill() {
  if (!setup_.frame.capabilities().motion || !setup_.commands || frame_away_) co_return;
  const MonoTime stood = setup_.clock.now();
  const MonoTime limit = stood + std::max<Duration>(500ms, from_seconds(3 / setup_.frame_rate_Hz));
  while (force_known_ <= stood && !frame_away_ && setup_.clock.now() < limit) {
    co_await setup_.clock.wait_for(20ms);
  }
}

Task<> Run::finish(std::optional<InterruptRequest> stop, RunResult& result) {
  if (stop && stop->code == Errc::frame_fault) keep_hands_off(stop->why);
  finishing_ = true;
  stop_pending_ = false;
  progress_.state = RunState::finishing;
  guard_.expect_standstill();
  // A stop of the last instant is one, and whoever froze a run that was stopped means it.
  for (InterruptRequest& late : pending_) {
    const bool stops = late.kind != Interrupt::pause && late.kind != Interrupt::loss;
    if (late.kind == Interrupt::freeze || (stops && !stop)) stop = std::move(late);
  }
  pending_.clear();
  co_await stop_frame();
  if (frame_away_) co_await recover_frame_for_finally();
  result.exit_status = ExitStatus::success;
  if (stop) {
    const bool wanted = stop->kind == Interrupt::abort || stop->kind == Interrupt::freeze;
    result.exit_status = wanted ? ExitStatus::abort : ExitStatus::fail;
    result.reason = fmt::format("{}: {}", to_string(event_of(stop->kind)), stop->why);
    result.code = stop->code;
    if (setup_.commands) {
      auto line = co_await setup_.frame.resync();
      if (!line) event(EventKind::retry, line.error().what);
    }
  }
  if (stop && prepared_) co_await see_standstill();
  guard_.allow_return(rest_ ? rest_->scatter_N() : 0);
  const bool clears = may_clear(stop && stop->kind == Interrupt::freeze, result);
  if (clears) co_await run_finally(result);
  guard_.expect_standstill();
  co_await stop_frame();
  if (moves() && !standing_ && !frame_away_) {
    constexpr std::string_view kWhy = "standstill not confirmed: use the E-stop";
    const bool said = result.reason.find(kWhy) != std::string::npos;
    if (!said) fail_with(result, Errc::not_standing, kWhy);
    result.exit_status = ExitStatus::fail;
    result.code = Errc::not_standing;
  }
  tell_hands_off(result, clears);
  ending_ = true;
  stop_pending_ = false;
  if (moves() && prepared_) co_await tell_load(result);
  if (moves_again_ && standing_) {
    co_await stop_frame();
    fail_with(result, Errc::refused, *moves_again_ + "; it was stopped again");
  }
  co_await sampler_.stop();
  if (!meter_away_) {
    auto safe = co_await setup_.lcr.make_safe();
    if (!safe) event(EventKind::retry, safe.error().what);
  }
  setup_.frame.set_listener(nullptr);
  over_ = true;
  progress_.state = RunState::ended;
}

// Whether `finally` can and may run; says why not.
bool Run::may_clear(bool frozen, RunResult& result) {
  if (frozen) return false;
  if (!prepared_ && setup_.commands) return false;  // nothing was asked of the frame
  if (frame_away_) {
    if (result.exit_status == ExitStatus::success) {  // every step had ended well
      result.exit_status = ExitStatus::fail;
      result.reason = frame_away_->why.what;
      result.code = frame_away_->why.code;
    }
    add_note(result.reason,
             "`finally` did not run: the frame is not there; standstill is not "
             "confirmed: look at it, use the E-stop if it moves");
    return false;
  }
  if (hands_off_) return false;  // tell_hands_off says why
  if (moves() && !standing_) {
    result.exit_status = ExitStatus::fail;
    result.code = Errc::not_standing;
    add_note(result.reason,
             "`finally` did not run: standstill not confirmed: use the E-stop, then look at the "
             "rig");
    return false;
  }
  if (unconfirmed_) {
    add_note(
        result.reason,
        "`finally` did not run: nobody confirmed the specimen; look at it, and drive the frame "
        "away at the machine if it is loaded");
    return false;
  }
  if (setup_.commands && !guard_.is_distrusted() && guard_.is_pulled()) {
    add_note(
        result.reason,
        fmt::format("`finally` did not run: the specimen pulls at the probe with {:.3f} N, and "
                    "no way is known to be safe: free it by hand",
                    -force_N_.value_or(0)));
    return false;
  }
  return true;
}

// Runs whatever happened before; has its own deadline, after which the frame stays where it is.
Task<> Run::run_finally(RunResult& result) {
  const MonoTime deadline = setup_.clock.now() + setup_.protocol.finally_timeout;
  StepCursor cursor(setup_.protocol.finally_steps, setup_.environment);
  auto r = co_await (run_steps(cursor) || setup_.clock.wait_until(deadline));
  std::string why;
  Errc code = Errc::no_reply;
  if (r.index() == 1) {
    why = fmt::format("`finally` did not end in {:.0f} s; the frame was stopped where it stood",
                      to_seconds(setup_.protocol.finally_timeout));
  } else if (const auto& stop = std::get<0>(r)) {
    const bool frozen = stop->kind == Interrupt::freeze;
    why = fmt::format("in `finally`: {}{}", frozen ? "freeze: " : "", stop->why);
    code = stop->code;
  }
  if (why.empty()) co_return;
  event(EventKind::fault, why);
  fail_with(result, code, why);
}

// A force that an unloaded cell does not show.
bool Run::is_loaded(double force_N) const {
  const double rest_N = bare_ ? bare_->force_N() : 0;
  const double noise_N = bare_ ? bare_->scatter_N() : 0;
  const double allowed = std::max(5 * noise_N, 0.01 * setup_.limits.force_max_N);
  return force_N - rest_N > allowed;
}

double Run::zero_doubt_N() const {
  return kZeroDoubt * setup_.frame.capabilities().force_max.si();
}

// The specimen is unloaded, or the run says that it is not and what to do now.
Task<> Run::tell_load(RunResult& result) {
  auto rest = co_await watch_rest(200ms);
  const std::optional<double> travel_m = rest ? rest->travel_m() : memory_.travel_m;
  const double clear_m =
      contact_travel_m_ && travel_m ? *contact_travel_m_ - *travel_m : -kFarClear_m;
  const bool clear = clear_m > kClear_m;
  const bool surely = clear_m > kFarClear_m && plausible_ && plausible_->press().knows();
  // Contact was called where the search stood, which is inside of a specimen that it ran into: what
  // is shown counts there, too, if it is more than the zero of the cell can be off.
  const double doubt_N = clear ? zero_doubt_N() : 0;
  const bool pulls =
      rest && is_loaded(2 * (bare_ ? bare_->force_N() : 0) - rest->force_N() - zero_doubt_N());
  if (!hands_off_ && !frame_away_ && clear && !pulls &&
      (!rest || !is_loaded(rest->force_N() - doubt_N)))
    co_return;
  std::string why;
  if (!frame_away_ && !hands_off_ && rest && surely && !pulls) {
    why = fmt::format(
        "by its travel the probe is clear of the specimen, {:.3g} mm above contact, whatever the "
        "load cell shows ({:.3f} N): check its zero",
        clear_m * 1e3, rest->force_N());
  } else if (frame_away_ || !rest || guard_.is_distrusted()) {
    why = kUnknown;
  } else if (is_loaded(rest->force_N())) {
    why = fmt::format(
        "the specimen is still loaded with about {:.3f} N: drive the frame away from it "
        "at the machine",
        rest->force_N() - (bare_ ? bare_->force_N() : 0));
  }
  if (why.empty() && pulls) {
    why = fmt::format(
        "the specimen pulls at the probe with about {:.3f} N: free it by hand before the frame is "
        "moved",
        (bare_ ? bare_->force_N() : 0) - rest->force_N());
  }
  if (why.empty() && hands_off_) {
    why = fmt::format("the specimen is not loaded, as far as the cell shows ({:.3f} N)",
                      rest->force_N() - (bare_ ? bare_->force_N() : 0));
  }
  if (why.empty()) co_return;
  event(EventKind::loaded, why);
  fail_with(result, Errc::limit_tripped, why);
}

}  // namespace lcrig
