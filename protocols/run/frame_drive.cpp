// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/frame_drive.hpp"

#include <algorithm>
#include <boost/asio/this_coro.hpp>
#include <utility>

#include "base/clock.hpp"
#include "protocols/run/event_log.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/interrupts.hpp"
#include "protocols/run/progress_keeper.hpp"
#include "protocols/run/rest_meter.hpp"
#include "protocols/run/setup.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr int kTries = 2;  // the second at once, when the frame moves after it said that it stands
constexpr Duration kLook = 20ms;  // between two looks at the samples
// What is written when the frame confirms STOP and its samples show a motion.
constexpr const char* kMovesOn =
    "the frame confirmed STOP, and its samples show that it moves: standstill not confirmed: use "
    "the E-stop";

}  // namespace

FrameDrive::FrameDrive(const RunSetup& setup, const EventLog& log, InterruptQueue& interrupts,
                       FrameWatch& watch, const RestMeter& meter, StandstillWatch& still)
    : setup_(setup),
      log_(log),
      interrupts_(interrupts),
      watch_(watch),
      rig_(watch.rig()),
      meter_(meter),
      still_(still) {}

Task<Result<>> FrameDrive::take_command() {
  const FrameCapabilities& caps = rig_.frame.caps;
  forget_limits();
  if (!setup_.commands) {
    auto seen = co_await setup_.frame.observe(setup_.frame_rate_Hz);
    if (!seen) co_return fail(seen.error());
    co_return Result<>();
  }
  if (caps.motion || caps.weights) {
    auto armed = co_await arm(device_limits(rig_.limits, caps));
    if (!armed) co_return armed;
  }
  auto rate = co_await setup_.frame.set_sample_rate(setup_.frame_rate_Hz);
  if (!rate) co_return rate;
  watch_.restart_age();
  watch_.watch_age(caps.motion);
  if (!caps.motion) set_prepared(true);
  co_return Result<>();
}

Task<Result<>> FrameDrive::arm(FrameLimits limits) {
  if (auto may = may_move(); !may) co_return may;
  const int zeros = rig_.frame.travel_zeros;
  if (armed_ && armed_->limits == limits && armed_->travel_zeros == zeros) co_return Result<>();
  auto armed = co_await setup_.frame.arm(limits);
  if (armed) armed_ = Armed{limits, zeros};
  co_return armed;
}

Task<> FrameDrive::stop() {
  if (!setup_.moves()) {
    count_stop(true);
    co_return;
  }
  watch_.lose_motion();
  next_try_ = setup_.clock.now() + kAgain;
  Result<> stopped;
  for (int tries = 0; tries == 0 || (tries < kTries && still_.has_moved()); ++tries) {
    still_.ask(setup_.clock.now(), brakes());
    stopped = co_await setup_.frame.stop();
    const auto state = co_await asio::this_coro::cancellation_state;
    if (state.cancelled() != asio::cancellation_type::none) co_return;
    if (!stopped) break;
    log_.event(EventKind::stopped, "");
    still_.confirm(setup_.clock.now(), sample_period());
    co_await await_still_samples();
  }
  // A frame that counts as lost, and answers, is taken at its word until it is back.
  const bool stands = stopped && (still_.holds() || still_.is_lost());
  if (stands) {
    told_failed_ = false;
    watch_.stand();
  }
  count_stop(stands);
  if (!stands) tell_failed(stopped ? kMovesOn : stopped.error().what);
}

Task<> FrameDrive::stop_for_good() {
  still_.look_longer();
  return stop();
}

// One event for a stop that is tried again and again.
void FrameDrive::tell_failed(std::string why) {
  if (!std::exchange(told_failed_, true)) log_.event(EventKind::stop_failed, std::move(why));
}

Task<Stands> FrameDrive::stand_still() {
  while (!still_.holds()) {
    if (setup_.clock.now() < next_try_) co_await setup_.clock.wait_until(next_try_);
    co_await stop();
  }
  co_return Stands();
}

Task<> FrameDrive::await_still_samples() {
  while (still_.is_being_looked_at() && setup_.clock.now() < still_.look_ends()) {
    const MonoTime due = setup_.clock.now() + kLook;
    co_await setup_.clock.wait_until(due);
    still_.allow_lag(setup_.clock.now() - due);
  }
}

// A machine that decelerates slowly needs longer before it can confirm standstill.
Duration FrameDrive::brakes() const {
  const FrameCapabilities& caps = setup_.frame.capabilities();
  const double deceleration = caps.deceleration.si();
  if (!(deceleration > 0)) return caps.reaction;
  return caps.reaction + from_seconds(last_speed_m_s_ / deceleration);
}

// nullopt: samples are not coming, or not judged yet.
std::optional<Duration> FrameDrive::sample_period() const {
  if (!prepared() || !last_sample_) return std::nullopt;
  if (setup_.clock.now() - *last_sample_ > flowing()) return std::nullopt;
  return from_seconds(1 / setup_.frame_rate_Hz);
}

Duration FrameDrive::flowing() const {
  return stale_after(setup_.frame_rate_Hz);
}

void FrameDrive::note_order(double speed_m_s) {
  last_speed_m_s_ = std::abs(speed_m_s);
  next_try_ = MonoTime();
  still_.order(last_speed_m_s_);
}

void FrameDrive::see(const FrameSample& sample) {
  last_sample_ = sample.received;
  still_.take(sample, rig_.still_m());
}

Task<Result<>> FrameDrive::stop_silently() {
  still_.rejoin();
  still_.ask(setup_.clock.now(), brakes());
  auto stopped = co_await setup_.frame.stop();
  if (!stopped) co_return stopped;
  std::optional<Duration> period;
  if (prepared()) period = from_seconds(1 / setup_.frame_rate_Hz);  // samples will come
  still_.confirm(setup_.clock.now(), period);
  count_stop(true);
  co_return stopped;
}

void FrameDrive::count_stop(bool stands) {
  standing_ = stands;
  ++(stands ? stands_ : failed_stops_);
  if (setup_.on_stop) setup_.on_stop();
}

Task<Result<>> FrameDrive::hold_travel() {
  held_force_N_.reset();
  auto held = co_await setup_.frame.hold_travel();
  watch_.stand();
  co_return held;
}

Task<Result<>> FrameDrive::hold_force(double force_N) {
  if (auto may = may_move(); !may) co_return may;
  watch_.order(rig_.hold_now(force_N, meter_.noise_N()));
  note_order(0);
  co_return co_await setup_.frame.hold_force(Force::from_si(force_N));
}

Task<Result<>> FrameDrive::restore_hold() {
  if (!held_force_N_) co_return Result<>();
  co_return co_await hold_force(*held_force_N_);
}

void FrameDrive::doubt_standstill() {
  still_.contradict(setup_.clock.now());
}

bool FrameDrive::prepared() const {
  return rig_.is_prepared;
}

void FrameDrive::set_prepared(bool yes) {
  watch_.set_prepared(yes);
}

const std::optional<Error>& FrameDrive::hands_off() const {
  return rig_.trust.no_motion;
}

bool FrameDrive::keep_hands_off(std::string why, Errc code) {
  if (hands_off() || interrupts_.over()) return false;
  Error error(code, std::move(why));
  error.hands_off = true;
  watch_.lock_out_motion(error);
  held_force_N_.reset();
  forget_limits();
  log_.event(EventKind::hands_off, error.what);
  interrupts_.ask(InterruptRequest(Interrupt::fault, std::move(error)));
  return true;
}

Result<> FrameDrive::may_move() const {
  if (!setup_.commands) {
    return fail(Errc::bug,
                "this run only observes the frame, and a step wants to move it: the facts of the "
                "step are wrong");
  }
  return rig_.trust.may_move();
}

}  // namespace lcrig
