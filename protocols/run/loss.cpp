// SPDX-License-Identifier: Apache-2.0
// What a run does when an instrument vanishes. The frame holds its travel, or goes on holding the
// force if only the meter is away; the guard stays active; whoever asks for a stop gets it.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <utility>

#include "base/text.hpp"
#include "protocols/run/run.hpp"

namespace lcrig {

namespace {

using namespace asio::experimental::awaitable_operators;
using namespace std::chrono_literals;

// Between two attempts. With the meter's own 0.5 s after opening it is back within a second.
constexpr Duration kPause = 50ms;
constexpr Duration kReminder = 60s;  // between log lines while it is away
// A frame that is lost when the run ends is waited for so long: the specimen is still loaded.
constexpr Duration kFinallyPatience = 5s;
// More losses than this within a minute are a broken cable, not a lost plug.
constexpr std::size_t kLossesAMinute = 4;
constexpr double kForceTolerance = 0.05;  // of the force window, at rest at the same travel

bool is_absent(Errc code) {
  return code == Errc::disconnected || code == Errc::no_reply || code == Errc::reply_cut_off ||
         code == Errc::garbled || code == Errc::io || code == Errc::busy ||
         code == Errc::not_standing;
}

}  // namespace

void Run::lose_meter(Error error) {
  // `finally` unloads without readings; a step of it that needs the meter fails by itself.
  lose(meter_away_, last_reading_, std::move(error));
}

void Run::lose_frame(Error error) {
  guard_.set_watch_age(false);
  if (plausible_) plausible_->look_away();
  if (!memory_at_loss_) {
    memory_at_loss_ = memory_;
    memory_at_loss_->origin = setup_.frame.origin();
    if (in_motion_) memory_at_loss_->begun_m_s = order_speed_m_s_;  // a gateway may tell no times
  }
  lose(frame_away_, last_sample_, std::move(error));
}

void Run::lose(std::optional<Away>& away, const std::optional<MonoTime>& data, Error error) {
  if (over_ || away) return;
  const MonoTime now = setup_.clock.now();
  away.emplace(error, now, data.value_or(now));
  event(EventKind::loss, error.what);
  spdlog::warn("run {}: instrument lost: {}", setup_.run, printable(error.what));
  if (finishing_ && &away == &meter_away_) return;
  push_interrupt(InterruptRequest(Interrupt::loss, std::move(error)));
}

// An exchange that failed because its instrument vanished is no failure of the step.
bool Run::is_of_loss(const Step& step, const Error& error) const {
  if (frame_away_) return is_absent(error.code);
  const bool reads = std::holds_alternative<MeasureStep>(step.action) ||
                     std::holds_alternative<SetLcrStep>(step.action);
  return meter_away_ && reads && !finishing_;
}

bool Run::keeps_vanishing() {
  const MonoTime now = setup_.clock.now();
  std::erase_if(losses_, [&](MonoTime t) { return now - t > 60s; });
  losses_.push_back(now);
  return losses_.size() > kLossesAMinute;
}

// nullopt: it is back, and the step goes on (`wait`) or begins anew (`repeat_step`).
Task<std::optional<InterruptRequest>> Run::survive_loss(StepProgress& progress) {
  std::optional<InterruptRequest> stop;
  const Error why = frame_away_ ? frame_away_->why : meter_away_->why;
  const OnLoss policy = setup_.protocol.on_loss;
  const bool shaky = keeps_vanishing();
  const bool shaky_in_finally = finishing_ && ++losses_in_finally_ > kLossesAMinute;
  if (shaky_in_finally || (!finishing_ && (policy == OnLoss::abort || shaky))) {
    stop = InterruptRequest(Interrupt::fault, why);
    if (shaky) stop->why += fmt::format(" (lost {} times within a minute)", losses_.size());
    event(EventKind::fault, stop->why);
    co_return stop;
  }
  if (progress.begin) progress.spent += setup_.clock.now() - *progress.begin;
  progress.begin.reset();
  const RunState before = progress_.state;
  if (!finishing_) progress_.state = RunState::waiting_for_instrument;
  if (frame_away_ || !held_force_N_) co_await stop_frame();
  const Duration patience = finishing_ ? kFinallyPatience : setup_.protocol.on_loss_timeout;
  stop = co_await wait_for_return(patience);
  if (!stop && hands_off_) stop = InterruptRequest(Interrupt::fault, *hands_off_);
  if (stop) co_return stop;
  progress_.state = before;
  sampler_.start(setup_.protocol.sample.lcr_continuous);
  if (policy == OnLoss::repeat_step || finishing_) begin_again(progress);
  if (memory_at_loss_) {  // the frame was lost: it left force control
    memory_at_loss_.reset();
    auto held = co_await restore_hold();
    if (!held) stop = InterruptRequest(Interrupt::fault, held.error());
  }
  co_return stop;
}

Task<std::optional<InterruptRequest>> Run::wait_for_return(Duration patience) {
  const MonoTime limit = setup_.clock.now() + patience;
  std::optional<InterruptRequest> stop;
  while (is_away() && !stop) {
    auto r = co_await (bring_back() || interrupted() || setup_.clock.wait_until(limit));
    if (r.index() == 0) {
      const auto& back = std::get<0>(r);
      if (!back) stop = InterruptRequest(Interrupt::fault, back.error());
    } else if (r.index() == 1) {
      InterruptRequest request = take_interrupt();
      if (request.kind == Interrupt::pause) pause_wanted_ = true;
      const bool goes_on = request.kind == Interrupt::pause || request.kind == Interrupt::loss;
      if (!goes_on) stop = std::move(request);
    } else {
      const Away& away = frame_away_ ? *frame_away_ : *meter_away_;
      stop = InterruptRequest(Interrupt::fault, away.why);
      stop->why += fmt::format("; it did not come back within {:.0f} s ({} attempts, the last: {})",
                               to_seconds(patience), away.attempts, away.last);
    }
    if (stop && r.index() != 1 && !hands_off_) event(EventKind::fault, stop->why);
  }
  co_return stop;
}

// Ends when both are back, or with the reason why it is no use to wait.
Task<Result<>> Run::bring_back() {
  for (;;) {
    if (frame_away_) {
      auto tried = co_await try_frame();
      if (!tried) co_return tried;
    }
    if (meter_away_) {
      auto tried = co_await try_meter();
      if (!tried) co_return tried;
    }
    if (!is_away()) co_return Result<>();
    co_await setup_.clock.wait_for(kPause);
  }
}

void Run::note_attempt(Away& away, const Error& error) {
  ++away.attempts;
  // Another instrument on this port is worth a row, once.
  if (error.code == Errc::refused && away.last != error.what) {
    event(EventKind::refused, error.what);
    spdlog::warn("run {}: {}", setup_.run, printable(error.what));
  }
  away.last = error.what;
  const MonoTime now = setup_.clock.now();
  if (now - away.reported < kReminder) return;
  away.reported = now;
  spdlog::info("run {}: still away after {:.0f} s and {} attempts: {}", setup_.run,
               to_seconds(now - away.since), away.attempts, printable(error.what));
}

Task<Result<>> Run::try_meter() {
  if (sampler_.is_running()) sampler_.interrupt();  // a silent meter keeps an exchange waiting
  auto back = co_await sampler_.reconnect();
  if (back) {
    welcome(meter_away_, "lcr");
  } else if (back.error().code == Errc::invalid_request) {
    co_return fail(meter_away_->why);
  } else {
    note_attempt(*meter_away_, back.error());
  }
  co_return Result<>();
}

Task<Result<>> Run::try_frame() {
  auto identity = co_await setup_.frame.reconnect();
  if (!identity && identity.error().code == Errc::invalid_request) {
    co_return fail(frame_away_->why);
  }
  // Another machine, or this one with other abilities: it is no use to wait.
  if (!identity && identity.error().code == Errc::refused) {
    note_attempt(*frame_away_, identity.error());
    if (moves()) keep_hands_off(identity.error().what, Errc::refused);
    co_return fail(identity.error());
  }
  if (!identity) {
    note_attempt(*frame_away_, identity.error());
    co_return Result<>();
  }
  auto joined = co_await rejoin_frame();
  if (joined) co_return joined;
  if (!is_absent(joined.error().code)) co_return joined;
  note_attempt(*frame_away_, joined.error());
  co_return Result<>();
}

// It stands, obeys, is armed again, sends samples, and is where it was. One that is not is stopped
// and heard, no more.
Task<Result<>> Run::rejoin_frame() {
  if (setup_.commands) {
    auto stopped = co_await setup_.frame.stop();
    if (!stopped) co_return stopped;
    standing_ = true;
    ++stands_;
  }
  sample_clock_.forget();
  memory_ = FrameMemory();
  memory_.zeroed = memory_at_loss_ && memory_at_loss_->zeroed;
  Result<> same;
  if (memory_at_loss_) same = compare_origin(*memory_at_loss_);
  if (!same) {  // what it shows is no reason any more to trip a limit
    guard_.distrust_zero(setup_.frame.capabilities().force_max.si());
    if (plausible_) plausible_->distrust_force();
  }
  Result<> armed;
  if (same && !hands_off_) {
    armed = co_await arm_frame();
  } else {
    armed = co_await setup_.frame.set_sample_rate(setup_.frame_rate_Hz);
  }
  if (!armed) co_return armed;
  guard_.set_watch_age(false);
  auto heard = co_await await_samples();
  if (!heard) co_return heard;
  if (same && memory_at_loss_) same = compare_with(*memory_at_loss_);
  guard_.restart_age(setup_.clock.now());
  guard_.set_watch_age(setup_.frame.capabilities().motion && setup_.commands);
  if (plausible_) plausible_->stand(setup_.clock.now());
  welcome(frame_away_, "frame");
  if (!same) lose_origin(same.error().what);
  co_return Result<>();
}

Task<Result<>> Run::await_samples() {
  const double period_s = 1 / setup_.frame_rate_Hz;
  const MonoTime limit = setup_.clock.now() + std::max<Duration>(2s, from_seconds(3 * period_s));
  const MonoTime begin = setup_.clock.now();
  const std::int64_t before = samples_seen_;
  // Nothing is pressed with a cell that says nothing; the way back needs the travel only.
  const bool feels = moves() && !finishing_;
  const auto heard = [&] { return samples_seen_ > before && (!feels || force_known_ > begin); };
  while (!heard() && setup_.clock.now() < limit) co_await setup_.clock.wait_for(20ms);
  const bool needed = setup_.frame.capabilities().motion;
  if (samples_seen_ == before && needed) {
    co_return fail(Errc::no_reply, "the frame sends no samples");
  }
  if (!heard() && needed) co_return fail(Errc::no_reply, "the frame sends no force");
  co_return Result<>();
}

// Told at once, before anything is armed.
Result<> Run::compare_origin(const FrameMemory& before) const {
  if (!moves() || !before.origin) return {};
  const auto now = setup_.frame.origin();
  if (now == before.origin) return {};
  return fail(Errc::refused,
              "the zero of force or travel was lost or changed meanwhile (origin {}, before it was "
              "{}): what the frame shows means nothing to this run any more",
              now.value_or("not stated"), *before.origin);
}

Result<> Run::compare_with(const FrameMemory& before) const {
  const FrameCapabilities& caps = setup_.frame.capabilities();
  if (!caps.motion || !setup_.commands) return {};  // a frame that others drive may be anywhere
  FrameTolerance allowed;
  allowed.force_N = kForceTolerance * (setup_.limits.force_max_N - setup_.limits.force_min_N);
  allowed.deceleration = caps.deceleration;
  if (rest_) allowed.rest_N = rest_->force_N(), allowed.noise_N = rest_->scatter_N();
  if (pressing_) {
    allowed.force_after_N = [this](double felt_N, double way_m) {
      return pressing_->forecast().bound().force_after_N(felt_N, way_m);
    };
  }
  return compare_frame(before, memory_, allowed);
}

void Run::welcome(std::optional<Away>& away, const char* instrument) {
  const MonoTime now = setup_.clock.now();
  const double without_s = to_seconds(now - away->data), away_s = to_seconds(now - away->since);
  event(GapEvent{instrument, without_s, away_s, away->attempts});
  event(ReconnectedEvent{instrument, without_s, away_s, away->attempts});
  spdlog::info("run {}: {} is back after {:.2f} s", setup_.run, instrument, away_s);
  away.reset();
}

// A level that is begun anew gets a number of its own; the readings of the one that was cut off
// stay, and an event says that they do not count.
void Run::begin_again(StepProgress& progress) {
  if (progress.level) {
    event(LevelAbandonedEvent{progress.level->level, progress.readings});
    --level_in_repeat_;
  }
  const auto start_travel_m = progress.start_travel_m, away_m = progress.away_m;
  progress = StepProgress();
  progress.start_travel_m = start_travel_m;
  progress.away_m = away_m;
  event(EventKind::repeat, "the step begins anew");
}

Task<Result<>> Run::restore_hold() {
  if (!held_force_N_) co_return Result<>();
  if (auto may = may_move(); !may) co_return may;
  if (plausible_) plausible_->begin(holding(), setup_.clock.now());
  auto held = co_await setup_.frame.hold_force(Force::from_si(*held_force_N_));
  co_return held;
}

// The run ends and its frame is not there: `finally` needs it.
Task<> Run::recover_frame_for_finally() {
  const MonoTime limit = setup_.clock.now() + kFinallyPatience;
  do {
    auto tried = co_await try_frame();
    if (!tried) {
      event(EventKind::fault, tried.error().what);
      co_return;
    }
    if (frame_away_) co_await setup_.clock.wait_for(kPause);
  } while (frame_away_ && setup_.clock.now() < limit);
}

}  // namespace lcrig
