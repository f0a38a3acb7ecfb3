// SPDX-License-Identifier: Apache-2.0
// An event row on its way from whoever saw something to the database and to those who watch.
#pragma once

#include <string>
#include <utility>

#include "base/clock.hpp"
#include "events/event_kind.hpp"
#include "events/payloads.hpp"

namespace lcrig {

struct RunEvent {
  RunEvent() = default;
  RunEvent(MonoTime at, EventName what, std::string step, std::string text)
      : t(at), kind(std::move(what)), step_id(std::move(step)), detail(std::move(text)) {}
  MonoTime t;
  EventName kind = EventKind::other;
  std::string step_id;
  std::string detail;  // the payload as JSON, or words for people
};

}  // namespace lcrig
