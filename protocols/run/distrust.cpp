// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/distrust.hpp"

#include <fmt/format.h>

#include "base/text.hpp"

namespace lcrig {

void Distrust::judge(const FrameSample& sample) {
  auto no = watch_.check(sample);
  if (interrupts_.stop_pending()) return;
  if (watch_.has_ended()) {
    if (!no || no->disbelief != Disbelief::stillness) return;
    moves_again_ = no->why;
    drive_.doubt_standstill();
    return;
  }
  if (no) disbelieve(*no);
}

void Distrust::disbelieve(const Contradiction& contradiction) {
  const std::string& why = contradiction.why;
  watch_.look_away();
  log_.event(EventKind::contradiction, why);
  switch (contradiction.disbelief) {
    case Disbelief::force:
      distrust_force();
      watch_.distrust_pressing(why);
      break;
    case Disbelief::drive: drive_.keep_hands_off(why); return;
    case Disbelief::stillness: drive_.doubt_standstill(); break;
  }
  interrupts_.ask(InterruptRequest(Interrupt::fault, Error(Errc::refused, why)));
}

void Distrust::forget_places(const std::string& why) {
  distrust_force();
  contact_.forget();
  watch_.distrust_pressing(why);
}

bool Distrust::lose_origin(const std::string& why) {
  forget_places(why);
  return drive_.keep_hands_off(why, Errc::refused);
}

void Distrust::heed(const EventName& kind, const std::string& detail) {
  if (!setup_.commands) return;
  if (kind == EventKind::device_origin && !zeroing_) distrust_zero(detail);
  const auto fault = frame_fault_words(kind.kind());
  if (fault) heed_fault(*fault, detail);
}

// E-stop, drive off, shield: resetting them at the machine does not yet allow the frame to move.
void Distrust::heed_fault(std::string_view what, const std::string& detail) {
  drive_.keep_hands_off(
      fmt::format("the frame reports {} ({}): clear it at the machine", what, printable(detail)));
}

std::string_view Distrust::cause_of_zero() const {
  return cut_zero_
             ? "by a `zero` of this run, which was interrupted and then carried out all the same"
             : "at the machine";
}

// Limits, contact and predictions referred to the old zero. From here the only way back is away
// from the specimen.
void Distrust::distrust_zero(const std::string& detail) {
  const std::string why = fmt::format(
      "the zero of force or travel was changed {} ({}): what it shows means nothing to this run "
      "any more",
      cause_of_zero(), detail);
  forget_places(why);
  drive_.forget_limits();
  if (cut_zero_ && interrupts_.frozen()) return;  // a person froze it, and nothing moves any more
  interrupts_.ask(InterruptRequest(Interrupt::fault, Error(Errc::refused, why)));
}

}  // namespace lcrig
