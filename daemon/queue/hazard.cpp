// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/hazard.hpp"

#include <algorithm>

namespace lcrig {

std::string_view words_of(Hazard hazard) {
  switch (hazard) {
    case Hazard::not_standing:
      return "standstill was not confirmed: use the E-stop, then look at the rig";
    case Hazard::left_loaded:
      return "the specimen may still be loaded: look at the rig, drive the frame away at the "
             "machine";
    case Hazard::frame_fault:
      return "the frame reported a fault, or is not believed: look at it and clear the fault";
    case Hazard::limit: return "a limit was reached: look at the specimen and at the limits";
    case Hazard::other_instrument: return "another instrument answered: look at what is connected";
    default: return {};
  }
}

std::optional<Hazard> hazard_of(const EventName& kind) {
  switch (kind.kind()) {
    case EventKind::stop_failed: return Hazard::not_standing;
    case EventKind::loaded: return Hazard::left_loaded;
    case EventKind::limit: return Hazard::limit;
    case EventKind::hands_off:
    case EventKind::contradiction:
    case EventKind::device_estop:
    case EventKind::device_drive_off:
    case EventKind::device_drive_fault:
    case EventKind::device_shield: return Hazard::frame_fault;
    case EventKind::refused: return Hazard::other_instrument;
    default: return std::nullopt;
  }
}

std::optional<Hazard> hazard_of(Errc code) {
  switch (code) {
    case Errc::not_standing: return Hazard::not_standing;
    case Errc::frame_fault: return Hazard::frame_fault;
    case Errc::limit_tripped: return Hazard::limit;
    default: return std::nullopt;
  }
}

void HazardWatch::take(std::optional<Hazard> hazard) {
  if (!hazard) return;
  worst_ = worst_ ? std::min(*worst_, *hazard) : *hazard;
}

}  // namespace lcrig
