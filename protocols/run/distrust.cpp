// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/distrust.hpp"

#include <fmt/format.h>

#include "base/text.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

void Distrust::judge(const FrameSample& sample) {
  auto no = run_.truth.check(sample);
  if (run_.interrupts.stop_pending()) return;
  if (ended_) {
    if (no && no->disbelief == Disbelief::stillness) moves_again_ = no->why;
    return;
  }
  if (!no) no = run_.truth.check_fall(sample);
  if (no) disbelieve(*no);
}

void Distrust::disbelieve(const Contradiction& contradiction) {
  const std::string& why = contradiction.why;
  run_.truth.look_away();
  run_.log.event(EventKind::contradiction, why);
  switch (contradiction.disbelief) {
    case Disbelief::force:
      distrust_force();
      if (run_.pressing != nullptr) run_.pressing->distrust(why);
      break;
    case Disbelief::drive: return run_.drive.keep_hands_off(why);
    case Disbelief::stillness: break;
  }
  run_.interrupts.ask(InterruptRequest(Interrupt::fault, Error(Errc::refused, why)));
}

void Distrust::distrust_force() {
  run_.truth.distrust_force();
  run_.guard.distrust_zero(run_.setup.frame.capabilities().force_max.si());
}

void Distrust::forget_places(const std::string& why) {
  distrust_force();
  run_.contact.forget();
  if (run_.pressing != nullptr) run_.pressing->distrust(why);
}

void Distrust::lose_origin(const std::string& why) {
  forget_places(why);
  run_.drive.keep_hands_off(why, Errc::refused);
}

void Distrust::heed(const EventName& kind, const std::string& detail) {
  if (!run_.setup.commands) return;
  if (kind == EventKind::device_origin && !zeroing_) distrust_zero(detail);
  if (is_frame_fault(kind.kind())) heed_fault(kind, detail);
}

// E-stop, drive off, shield: whoever resets it does not thereby say that the frame may move.
void Distrust::heed_fault(const EventName& kind, const std::string& detail) {
  constexpr std::string_view kFromDevice = "device_";
  const std::string what =
      kind == EventKind::motion_fault ? "a fault" : kind.word().substr(kFromDevice.size());
  run_.drive.keep_hands_off(
      fmt::format("the frame reports {} ({}): clear it at the machine", what, printable(detail)));
}

// Limits, contact and predictions were of the zero before. The way back is the way away from here.
void Distrust::distrust_zero(const std::string& detail) {
  const std::string why = fmt::format(
      "the zero of force or travel was changed at the machine ({}): what it shows means nothing "
      "to this run any more",
      detail);
  forget_places(why);
  run_.drive.forget_limits();
  run_.interrupts.ask(InterruptRequest(Interrupt::fault, Error(Errc::refused, why)));
}

}  // namespace lcrig
