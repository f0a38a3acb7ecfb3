// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/frame_drive.hpp"

#include <utility>

namespace lcrig {

Task<Result<>> FrameDrive::take_command() {
  const FrameCapabilities caps = contact_.frame_capabilities();
  forget_limits();
  if (!setup_.commands) {
    auto seen = co_await setup_.frame.observe(setup_.frame_rate_Hz);
    if (!seen) co_return fail(seen.error());
    co_return Result<>();
  }
  if (caps.motion || caps.weights) {
    auto armed = co_await arm(device_limits(guard_.limits(), caps));
    if (!armed) co_return armed;
  }
  auto rate = co_await setup_.frame.set_sample_rate(setup_.frame_rate_Hz);
  if (!rate) co_return rate;
  guard_.restart_age(setup_.clock.now());
  guard_.set_watch_age(caps.motion);
  prepared_ = prepared_ || !caps.motion;
  co_return Result<>();
}

Task<Result<>> FrameDrive::arm(FrameLimits limits) {
  if (auto may = may_move(); !may) co_return may;
  if (armed_ == limits) co_return Result<>();
  auto armed = co_await setup_.frame.arm(limits);
  if (armed) armed_ = limits;
  co_return armed;
}

Task<> FrameDrive::stop() {
  if (!setup_.moves()) {
    count_stop(true);
    co_return;
  }
  truth_.look_away();
  auto stopped = co_await setup_.frame.stop();
  if (stopped) truth_.stand();
  count_stop(stopped.has_value());
  log_.event(stopped ? EventKind::stopped : EventKind::stop_failed,
             stopped ? "" : stopped.error().what);
}

Task<Result<>> FrameDrive::stop_silently() {
  auto stopped = co_await setup_.frame.stop();
  if (stopped) count_stop(true);
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
  truth_.stand();
  co_return held;
}

Task<Result<>> FrameDrive::hold_force(double force_N) {
  if (auto may = may_move(); !may) co_return may;
  truth_.begin_hold();
  co_return co_await setup_.frame.hold_force(Force::from_si(force_N));
}

Task<Result<>> FrameDrive::restore_hold() {
  if (!held_force_N_) co_return Result<>();
  co_return co_await hold_force(*held_force_N_);
}

bool FrameDrive::keep_hands_off(std::string why, Errc code) {
  if (hands_off_ || interrupts_.over()) return false;
  hands_off_ = Error(code, std::move(why));
  hands_off_->hands_off = true;
  held_force_N_.reset();
  forget_limits();
  log_.event(EventKind::hands_off, hands_off_->what);
  interrupts_.ask(InterruptRequest(Interrupt::fault, *hands_off_));
  return true;
}

Result<> FrameDrive::may_move() const {
  if (!setup_.commands) {
    return fail(Errc::bug,
                "this run only observes the frame, and a step wants to move it: the facts of the "
                "step are wrong");
  }
  if (!hands_off_) return {};
  Error refusal = *hands_off_;
  refusal.what += ": nothing is moved any more";
  return fail(std::move(refusal));
}

}  // namespace lcrig
