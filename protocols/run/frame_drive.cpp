// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/frame_drive.hpp"

#include <utility>

#include "protocols/run/run_parts.hpp"

namespace lcrig {

Task<Result<>> FrameDrive::take_command() {
  const FrameCapabilities caps = run_.contact.frame_capabilities();
  forget_limits();
  if (!run_.setup.commands) {
    auto seen = co_await run_.setup.frame.observe(run_.setup.frame_rate_Hz);
    if (!seen) co_return fail(seen.error());
    co_return Result<>();
  }
  if (caps.motion || caps.weights) {
    auto armed = co_await arm(device_limits(run_.guard.limits(), caps));
    if (!armed) co_return armed;
  }
  auto rate = co_await run_.setup.frame.set_sample_rate(run_.setup.frame_rate_Hz);
  if (!rate) co_return rate;
  run_.guard.restart_age(run_.setup.clock.now());
  run_.guard.set_watch_age(caps.motion);
  prepared_ = prepared_ || !caps.motion;
  co_return Result<>();
}

Task<Result<>> FrameDrive::arm(FrameLimits limits) {
  if (auto may = may_move(); !may) co_return may;
  if (armed_ == limits) co_return Result<>();
  auto armed = co_await run_.setup.frame.arm(limits);
  if (armed) armed_ = limits;
  co_return armed;
}

Task<> FrameDrive::stop() {
  if (!run_.setup.moves()) {
    count_stop(true);
    co_return;
  }
  run_.truth.look_away();
  auto stopped = co_await run_.setup.frame.stop();
  if (stopped) run_.truth.stand();
  count_stop(stopped.has_value());
  run_.log.event(stopped ? EventKind::stopped : EventKind::stop_failed,
                 stopped ? "" : stopped.error().what);
}

Task<Result<>> FrameDrive::stop_silently() {
  auto stopped = co_await run_.setup.frame.stop();
  if (stopped) count_stop(true);
  co_return stopped;
}

void FrameDrive::count_stop(bool stands) {
  standing_ = stands;
  ++(stands ? stands_ : failed_stops_);
  if (run_.setup.on_stop) run_.setup.on_stop();
}

Task<Result<>> FrameDrive::hold_travel() {
  held_force_N_.reset();
  auto held = co_await run_.setup.frame.hold_travel();
  run_.truth.stand();
  co_return held;
}

Task<Result<>> FrameDrive::hold_force(double force_N) {
  if (auto may = may_move(); !may) co_return may;
  run_.truth.begin_hold();
  co_return co_await run_.setup.frame.hold_force(Force::from_si(force_N));
}

Task<Result<>> FrameDrive::restore_hold() {
  if (!held_force_N_) co_return Result<>();
  co_return co_await hold_force(*held_force_N_);
}

void FrameDrive::keep_hands_off(std::string why, Errc code) {
  if (hands_off_ || run_.interrupts.over()) return;
  hands_off_ = Error(code, why);
  held_force_N_.reset();
  forget_limits();
  run_.log.event(EventKind::hands_off, why);
  run_.interrupts.ask(InterruptRequest(Interrupt::fault, Error(code, std::move(why))));
}

Result<> FrameDrive::may_move() const {
  if (!hands_off_) return {};
  return fail(hands_off_->code, "{}: nothing is moved any more", hands_off_->what);
}

}  // namespace lcrig
