// SPDX-License-Identifier: Apache-2.0
// When a run no longer believes its frame: what it shows, or that it obeys.
#include <fmt/format.h>

#include <utility>

#include "base/text.hpp"
#include "protocols/file/words.hpp"
#include "protocols/run/run.hpp"

namespace lcrig {

namespace {

constexpr std::string_view kNotRun = "`finally` did not run";

}  // namespace

// The frame is stopped as ever; after that only a person moves it.
void Run::keep_hands_off(std::string why, Errc code) {
  if (hands_off_ || over_) return;
  hands_off_ = Error(code, why);
  held_force_N_.reset();
  armed_.reset();
  event(EventKind::hands_off, why);
  interrupt(InterruptRequest(Interrupt::fault, Error(code, std::move(why))));
}

// Asked before whatever moves the frame.
Result<> Run::may_move() const {
  if (!hands_off_) return {};
  return fail(hands_off_->code, "{}: nothing is moved any more", hands_off_->what);
}

// A reason that does not name the fault yet does so now.
void Run::tell_hands_off(RunResult& result, bool cleared) const {
  if (!hands_off_) return;
  if (result.exit_status == ExitStatus::success) {  // every step had ended well
    result.exit_status = ExitStatus::fail;
    result.code = hands_off_->code;
  }
  const bool named = result.reason.find(hands_off_->what) != std::string::npos;
  if (!named) add_note(result.reason, hands_off_->what);
  cleared = cleared || result.reason.find(kNotRun) != std::string::npos;
  add_note(result.reason,
           fmt::format("{}nothing is moved any more until a person has looked at the rig",
                       cleared ? "" : fmt::format("{}: ", kNotRun)));
}

// E-stop, drive off, shield: whoever resets it does not thereby say that the frame may move.
void Run::heed_fault(const EventName& kind, const std::string& detail) {
  constexpr std::string_view kFromDevice = "device_";
  const std::string what =
      kind == EventKind::motion_fault ? "a fault" : kind.word().substr(kFromDevice.size());
  keep_hands_off(
      fmt::format("the frame reports {} ({}): clear it at the machine", what, printable(detail)));
}

// Not even the way away from here is known: contact and limits are places of another zero.
void Run::lose_origin(const std::string& why) {
  guard_.distrust_zero(setup_.frame.capabilities().force_max.si());
  if (plausible_) plausible_->distrust_force();
  contact_travel_m_.reset();
  if (pressing_) pressing_->distrust(why);
  keep_hands_off(why, Errc::refused);
}

// Limits, contact and predictions were of the zero before. The way back is the way away from here.
void Run::distrust_zero(const std::string& detail) {
  const std::string why = fmt::format(
      "the zero of force or travel was changed at the machine ({}): what it shows means nothing "
      "to this run any more",
      detail);
  guard_.distrust_zero(setup_.frame.capabilities().force_max.si());
  if (plausible_) plausible_->distrust_force();
  contact_travel_m_.reset();
  if (pressing_) pressing_->distrust(why);
  armed_.reset();
  interrupt(InterruptRequest(Interrupt::fault, Error(Errc::refused, why)));
}

}  // namespace lcrig
