// SPDX-License-Identifier: Apache-2.0
// An event of a run on its way to the database and to the clients that watch. Every part of a run
// makes events; the recorder stores them.
#pragma once

#include <any>
#include <string>
#include <utility>

#include "base/time.hpp"
#include "events/event_kind.hpp"
#include "events/payloads.hpp"

namespace lcrig {

struct RunEvent {
  RunEvent() = default;
  RunEvent(MonoTime at, EventName what, std::string step, std::string text)
      : t(at), kind(std::move(what)), step_id(std::move(step)), detail(std::move(text)) {}
  template <EventPayload P>
  RunEvent(MonoTime at, std::string step, const P& what)
      : t(at), kind(P::kKind), step_id(std::move(step)), detail(to_json(what)), payload_(what) {}
  // The payload that it was made from; nullptr: it has another payload, or words only.
  template <EventPayload P>
  const P* as() const {
    return std::any_cast<P>(&payload_);
  }

  MonoTime t;
  EventName kind = EventKind::other;
  std::string step_id;
  std::string detail;  // the payload as JSON, or words for people

 private:
  std::any payload_;
};

}  // namespace lcrig
