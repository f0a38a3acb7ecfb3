// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/response.hpp"

#include <fmt/format.h>

#include "base/text.hpp"
#include "protocols/checks/check.hpp"
#include "protocols/run/event_log.hpp"
#include "protocols/run/frame_drive.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/interrupts.hpp"
#include "protocols/run/setup.hpp"

namespace lcrig {

void Responses::note(const Finding& finding) const {
  log_.event(finding.check->event, finding.why);
}

void Responses::act(const std::vector<Finding>& findings) {
  if (findings.empty()) return;
  const ScopedFlag answering = watch_.answer_sample();
  for (const Finding& finding : findings) {
    if (finding.check->response <= Response::no_pressing) note(finding);
  }
  if (interrupts_.stop_pending()) return;
  if (watch_.rig().phase == RunPhase::ended) return note_motion(findings);
  const Finding* worst = most_severe(findings);
  if (worst == nullptr) return;
  if (worst->check->event == EventKind::limit) {
    note(*worst);
    interrupts_.ask(InterruptRequest(Interrupt::limit, worst->why));
    return;
  }
  act(worst->check->doubt, worst->check->response, worst->why);
}

// After the end of the run.
void Responses::note_motion(const std::vector<Finding>& findings) {
  for (const Finding& finding : findings) {
    if (finding.check->doubt != Doubt::standstill) continue;
    moves_again_ = finding.why;
    drive_.doubt_standstill();
    return;
  }
}

void Responses::act(Doubt doubt, Response response, const std::string& why) {
  watch_.lose_motion();
  log_.event(EventKind::contradiction, why);
  if (doubt == Doubt::force) {
    watch_.invalidate_force();
    watch_.lock_out_pressing(why);
  }
  if (doubt == Doubt::standstill) drive_.doubt_standstill();
  if (response == Response::lock_out) {
    drive_.keep_hands_off(why);
    return;
  }
  interrupts_.ask(InterruptRequest(Interrupt::fault, Error(Errc::refused, why)));
}

ScopedFlag Responses::expect_zero(bool travel) {
  cut_zero_ = true;
  if (travel) watch_.lose_motion();
  return ScopedFlag(zeroing_);
}

void Responses::forget_places(const std::string& why) {
  watch_.invalidate_force();
  watch_.lose_contact();
  watch_.lock_out_pressing(why);
}

bool Responses::lose_origin(const std::string& why) {
  forget_places(why);
  return drive_.keep_hands_off(why, Errc::refused);
}

void Responses::handle(const EventName& kind, const std::string& detail) {
  if (!setup_.commands) return;
  if (kind == EventKind::device_origin && !zeroing_) handle_zero(detail);
  // E-stop, drive off, shield: resetting them at the machine does not yet allow the frame to move.
  if (const auto fault = frame_fault_words(kind.kind())) {
    drive_.keep_hands_off(fmt::format("the frame reports {} ({}): clear it at the machine", *fault,
                                      printable(detail)));
  }
}

std::string_view Responses::cause_of_zero() const {
  return cut_zero_
             ? "by a `zero` of this run, which was interrupted and then carried out all the same"
             : "at the machine";
}

// Limits, contact and predictions referred to the old zero. From here the only retreat is away from
// the specimen.
void Responses::handle_zero(const std::string& detail) {
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
