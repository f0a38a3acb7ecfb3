// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/losses.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "base/either.hpp"
#include "base/text.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/interrupts.hpp"
#include "protocols/run/run_parts.hpp"
#include "protocols/run/scoped_flag.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

// Between two attempts. Together with its own 0.5 s after opening, the meter is back within a
// second.
constexpr Duration kPause = 50ms;
constexpr Duration kReminder = 60s;  // between log lines during the absence
// How long the end of a run waits for a lost frame, because the specimen is still loaded.
constexpr Duration kFinallyPatience = 5s;
// More losses than this within a minute mean a broken cable, not a pulled plug.
constexpr std::size_t kLossesAMinute = 4;
constexpr double kForceTolerance = 0.05;  // of the force window, for a frame at rest at the same
                                          // travel

bool is_absent(Errc code) {
  return code == Errc::disconnected || code == Errc::no_reply || code == Errc::reply_cut_off ||
         code == Errc::garbled || code == Errc::io || code == Errc::busy ||
         code == Errc::not_standing;
}

}  // namespace

Losses::Losses(RunParts& run) : run_(run), stated_steps_(run.setup.frame.capabilities()) {}

void Losses::lose_meter(Error error) {
  // `finally` unloads without readings. A step of it that needs the meter fails by itself.
  lose(meter_, last_reading_, std::move(error));
}

void Losses::lose_frame(Error error) {
  run_.watch.watch_age(false);
  run_.watch.lose_motion();
  run_.drive.lose_link();
  if (!memory_at_loss_) {
    memory_at_loss_ = run_.rig.frame.seen;
    memory_at_loss_->origin = run_.setup.frame.origin();
    // Samples without device times give no speed.
    if (run_.motions.in_motion()) memory_at_loss_->begun_m_s = run_.motions.last_speed_m_s();
  }
  lose(frame_, run_.rig.frame.last_sample, std::move(error));
}

void Losses::lose(std::optional<Away>& away, const std::optional<MonoTime>& data, Error error) {
  if (run_.interrupts.over() || away) return;
  const MonoTime now = run_.setup.clock.now();
  away.emplace(error, now, data.value_or(now));
  run_.event(EventKind::loss, error.what);
  tell(away, &error);
  spdlog::warn("run {}: instrument lost: {}", run_.setup.run, printable(error.what));
  if (run_.interrupts.finishing() && &away == &meter_) return;
  run_.interrupts.push(InterruptRequest(Interrupt::loss, std::move(error)));
}

void Losses::tell(const std::optional<Away>& away, const Error* lost) const {
  if (run_.setup.on_loss) run_.setup.on_loss(which(away), lost);
}

void Losses::judge_age(std::span<const FrameSample> samples) {
  const MonoTime now = run_.setup.clock.now();
  const auto finding = sample_clock_.add(samples);
  if (finding.news) run_.event(finding.news->first, finding.news->second);
  for (const auto& [kind, words] : stated_steps_.add(samples)) run_.event(kind, words);
  const auto own_lag = run_.interrupts.own_lag(now);
  if (finding.age_s <= SampleClock::kLate_s || !own_lag) return;
  const bool ours = finding.age_s - to_seconds(*own_lag) <= SampleClock::kLate_s;
  if (now - age_told_ >= 1s || age_told_ == MonoTime()) {
    age_told_ = now;
    if (ours) {
      run_.event(EventKind::lag,
                 fmt::format("samples of the frame waited in this computer: they are {:.2f} s old, "
                             "because lcrigd was {:.2f} s late",
                             finding.age_s, to_seconds(*own_lag)));
    } else {
      run_.event(LateSamplesEvent{finding.age_s});
    }
  }
  if (ours || !run_.motions.in_motion() || run_.interrupts.finishing()) return;
  lose_frame(
      Error(Errc::no_reply, fmt::format("the samples of the frame are {:.2f} s old when they "
                                        "arrive: nobody can watch a motion like that",
                                        finding.age_s)));
}

void Losses::look() {
  const MonoTime now = run_.setup.clock.now();
  const bool away_before = is_away();
  if (auto silence = find_silence(run_.rig, now); silence && !run_.interrupts.stop_pending()) {
    lose_frame(Error(Errc::no_reply, std::move(silence->why)));
  }
  if (auto why = run_.sampler.check_age(now)) lose_meter(Error(Errc::no_reply, std::move(*why)));
  const bool finishing = run_.interrupts.finishing();
  const bool told = away_before && (finishing || surviving_);
  const bool matters = frame_ || (meter_ && !finishing);
  if (!matters || told) return;
  run_.interrupts.push(InterruptRequest(Interrupt::loss, first_away().why));
}

bool Losses::is_of_loss(const Step& step, const Error& error) const {
  if (frame_) return is_absent(error.code);
  return meter_ && facts_of(step).needs_meter() && !run_.interrupts.finishing();
}

bool Losses::keeps_vanishing() {
  const MonoTime now = run_.setup.clock.now();
  std::erase_if(losses_, [&](MonoTime t) { return now - t > 60s; });
  losses_.push_back(now);
  return losses_.size() > kLossesAMinute;
}

// The reason to give up; nullopt: wait for the instrument.
std::optional<InterruptRequest> Losses::give_up() {
  const bool finishing = run_.interrupts.finishing();
  const bool shaky = keeps_vanishing();
  const bool shaky_in_finally = finishing && ++losses_in_finally_ > kLossesAMinute;
  const bool may_wait = run_.setup.protocol.on_loss != OnLoss::abort && !shaky;
  if (finishing ? !shaky_in_finally : may_wait) return std::nullopt;
  InterruptRequest stop(Interrupt::fault, first_away().why);
  if (shaky) stop.why += fmt::format(" (lost {} times within a minute)", losses_.size());
  run_.event(EventKind::fault, stop.why);
  return stop;
}

Task<std::optional<InterruptRequest>> Losses::survive(StepProgress& progress) {
  std::optional<InterruptRequest> stop = give_up();
  if (stop) co_return stop;
  const bool finishing = run_.interrupts.finishing();
  progress.interrupt(run_.setup.clock.now());
  std::optional<ScopedFlag> surviving(std::in_place, surviving_);
  std::optional<ProgressKeeper::Shown> stopping;
  if (!finishing) stopping.emplace(run_.progress.show<RunState::stopping>());
  // The link may be alive, though nothing is heard.
  const bool moves = finishing && !run_.drive.held_force_N();
  if (frame_ || moves) co_await run_.drive.stop();
  const Duration patience = finishing ? kFinallyPatience : run_.setup.protocol.on_loss_timeout;
  stop = co_await wait_for_return(patience);
  const auto& hands_off = run_.drive.hands_off();
  if (!stop && hands_off) stop = InterruptRequest(Interrupt::fault, *hands_off);
  if (stop) co_return stop;
  stopping.reset();
  surviving.reset();
  run_.sampler.start(run_.setup.protocol.sample.lcr_continuous);
  const bool anew = run_.setup.protocol.on_loss == OnLoss::repeat_step || finishing;
  if (anew) {
    progress.begin_again(run_);
    run_.event(EventKind::repeat, "the step begins anew");
  }
  if (memory_at_loss_) {  // the frame was lost, and so left force control
    memory_at_loss_.reset();
    auto held = co_await run_.drive.restore_hold();
    if (!held) stop = InterruptRequest(Interrupt::fault, held.error());
  }
  co_return stop;
}

Task<std::optional<InterruptRequest>> Losses::wait_for_return(Duration patience) {
  const MonoTime limit = run_.setup.clock.now() + patience;
  std::optional<InterruptRequest> stop;
  std::optional<Error> useless;
  for (bool there = false; !there && !stop;) {
    auto r = co_await either(come_back(useless), run_.interrupts.wait(limit));
    const bool interrupted = r.index() == 1 && !run_.interrupts.empty();
    if (r.index() == 0) {
      there = !useless;
      if (useless) co_return InterruptRequest(Interrupt::fault, std::move(*useless));
    } else if (interrupted) {
      InterruptRequest request = run_.interrupts.take();
      if (request.kind == Interrupt::pause) pause_wanted_ = true;
      const bool goes_on = request.kind == Interrupt::pause || request.kind == Interrupt::loss;
      if (!goes_on) stop = std::move(request);
    } else {
      stop = gave_up(patience);
    }
    if (stop && !interrupted) run_.event(EventKind::fault, stop->why);
  }
  co_return stop;
}

InterruptRequest Losses::gave_up(Duration patience) const {
  if (!is_away()) {
    return InterruptRequest(Interrupt::fault,
                            Error(Errc::not_standing,
                                  "the instrument is back, but standstill is not confirmed: use "
                                  "the E-stop"));
  }
  const Away& away = first_away();
  InterruptRequest stop(Interrupt::fault, away.why);
  stop.why += fmt::format("; it did not come back within {:.0f} s ({} attempts, the last: {})",
                          to_seconds(patience), away.attempts, away.last);
  return stop;
}

// With only the meter away the frame continues to hold a force, unless a person wants it to stand.
Task<ProgressKeeper::Shown> Losses::show_waiting() {
  if (run_.drive.is_holding_force() && !pause_wanted_) {
    co_return run_.progress.show<RunState::holding_force>();
  }
  co_return co_await run_.wait_as(RunState::waiting_for_instrument);
}

// Returns when both instruments are back and the frame stands, or, in `finally`, why waiting is
// useless.
Task<> Losses::come_back(std::optional<Error>& useless) {
  auto back = bring_back(useless);
  auto standing = stand_by();
  co_await both(std::move(back), std::move(standing));
}

// Shows that the run waits, once the frame stands.
Task<> Losses::stand_by() {
  if (run_.interrupts.finishing()) co_return;
  while (frame_) co_await run_.setup.clock.wait_for(kPause);
  const auto shown = co_await show_waiting();
  while (is_away()) co_await run_.setup.clock.wait_for(kPause);
}

// Returns when both instruments are back. When waiting is useless, it requests the end of the run,
// or says so where `finally` runs already: there a request would not be taken.
Task<> Losses::bring_back(std::optional<Error>& useless) {
  for (;;) {
    Result<> tried;
    if (frame_) tried = co_await try_frame();
    if (tried && meter_) tried = co_await try_meter();
    if (!tried) {
      if (!run_.drive.hands_off()) run_.event(EventKind::fault, tried.error().what);
      useless = tried.error();
      if (!run_.interrupts.finishing()) {
        run_.interrupts.push(InterruptRequest(Interrupt::fault, tried.error()));
      }
      co_return;
    }
    if (!is_away()) co_return;
    co_await run_.setup.clock.wait_for(kPause);
  }
}

void Losses::note_attempt(std::optional<Away>& of, const Error& error) {
  Away& away = *of;
  ++away.attempts;
  // Another instrument on this port is reported once, as an event.
  if (error.code == Errc::refused && away.last != error.what) {
    run_.event(EventKind::refused, error.what);
    tell(of, &error);
    spdlog::warn("run {}: {}", run_.setup.run, printable(error.what));
  }
  away.last = error.what;
  const MonoTime now = run_.setup.clock.now();
  if (now - away.reported < kReminder) return;
  away.reported = now;
  spdlog::info("run {}: still away after {:.0f} s and {} attempts: {}", run_.setup.run,
               to_seconds(now - away.since), away.attempts, printable(error.what));
}

Task<Result<>> Losses::try_meter() {
  if (run_.sampler.is_running()) {
    run_.sampler.interrupt();  // a silent meter would keep its exchange waiting
  }
  auto back = co_await run_.sampler.reconnect();
  if (back) {
    welcome(meter_);
  } else if (back.error().code == Errc::invalid_request) {
    co_return fail(meter_->why);
  } else {
    note_attempt(meter_, back.error());
  }
  co_return Result<>();
}

Task<Result<>> Losses::try_frame() {
  auto identity = co_await run_.setup.frame.reconnect();
  if (!identity && identity.error().code == Errc::invalid_request) co_return fail(frame_->why);
  // Another machine, or this one with other capabilities: waiting is useless.
  if (!identity && identity.error().code == Errc::refused) {
    note_attempt(frame_, identity.error());
    Error& refusal = identity.error();
    if (run_.setup.moves()) {
      refusal.hands_off = run_.drive.keep_hands_off(refusal.what, Errc::refused);
    }
    co_return fail(refusal);
  }
  if (!identity) {
    note_attempt(frame_, identity.error());
    co_return Result<>();
  }
  auto joined = co_await rejoin_frame();
  if (joined) co_return joined;
  if (!is_absent(joined.error().code)) co_return joined;
  note_attempt(frame_, joined.error());
  co_return Result<>();
}

// Brings the frame back into the run: it stands, obeys, is armed, sends samples, and is where it
// was. A frame with another zero or at another place is only stopped and listened to.
Task<Result<>> Losses::rejoin_frame() {
  if (run_.setup.commands) {
    auto stopped = co_await run_.drive.stop_silently();
    if (!stopped) co_return stopped;
  }
  sample_clock_.forget();
  run_.watch.link_back();
  Result<> same;
  if (memory_at_loss_) same = compare_origin(run_, *memory_at_loss_);
  if (!same) run_.watch.invalidate_force();  // then its force must not trip a limit
  Result<> armed;
  if (same && !run_.drive.hands_off()) {
    armed = co_await run_.drive.take_command();
  } else {
    armed = co_await run_.setup.frame.set_sample_rate(run_.setup.frame_rate_Hz);
  }
  if (!armed) co_return armed;
  run_.watch.watch_age(false);
  auto heard = co_await run_.meter.await_samples(run_.needs_force());
  if (!heard) co_return heard;
  if (same && memory_at_loss_) same = compare_place(run_, *memory_at_loss_);
  run_.watch.restart_age();
  run_.watch.watch_age(run_.setup.moves());
  run_.watch.stand();
  welcome(frame_);
  if (!same) run_.response.lose_origin(same.error().what);
  co_return Result<>();
}

void Losses::welcome(std::optional<Away>& away) {
  const std::string instrument(to_string(which(away)));
  const MonoTime now = run_.setup.clock.now();
  const double without_s = to_seconds(now - away->data), away_s = to_seconds(now - away->since);
  run_.event(GapEvent{instrument, without_s, away_s, away->attempts});
  run_.event(ReconnectedEvent{instrument, without_s, away_s, away->attempts});
  spdlog::info("run {}: {} is back after {:.2f} s", run_.setup.run, instrument, away_s);
  tell(away, nullptr);
  away.reset();
}

Task<> Losses::bring_frame_back() {
  const MonoTime limit = run_.setup.clock.now() + kFinallyPatience;
  do {
    auto tried = co_await try_frame();
    if (!tried) {
      run_.event(EventKind::fault, tried.error().what);
      co_return;
    }
    if (frame_) co_await run_.setup.clock.wait_for(kPause);
  } while (frame_ && run_.setup.clock.now() < limit);
}

Result<> compare_origin(RunParts& run, const LastSeen& before) {
  if (!run.setup.moves() || !before.origin) return {};
  const auto now = run.setup.frame.origin();
  if (now == before.origin) return {};
  const bool cut = run.response.has_cut_zero();
  return fail(Errc::refused,
              "the zero of force or travel was {} (origin {}, before it was {}): what the frame "
              "shows means nothing to this run any more",
              cut ? fmt::format("changed {}", run.response.cause_of_zero())
                  : std::string("lost or changed meanwhile"),
              now.value_or("not stated"), *before.origin);
}

Result<> compare_place(RunParts& run, const LastSeen& before) {
  if (!run.setup.moves()) return {};  // other users may have moved it anywhere
  FrameTolerance allowed;
  allowed.force_N = kForceTolerance * (run.setup.limits.force_max_N - run.setup.limits.force_min_N);
  allowed.deceleration = run.setup.frame.capabilities().deceleration;
  allowed.cell = run.setup.cell;
  allowed.rest_N = run.rig.cell.zero_N();
  allowed.noise_N = run.rig.cell.noise_N();
  if (run.rig.forecast) {
    allowed.force_after_N = [&run](double felt_N, double way_m) {
      return run.rig.forecast->bound().force_after_N(felt_N, way_m);
    };
  }
  return compare_frame(before, run.rig.frame.seen, allowed);
}

}  // namespace lcrig
