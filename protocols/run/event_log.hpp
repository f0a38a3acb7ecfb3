// SPDX-License-Identifier: Apache-2.0
// Writes the events of a run as rows, each with the step in which it happened. All parts of a run
// use it.
#pragma once

#include <string>

#include "base/time.hpp"
#include "events/payloads.hpp"
#include "protocols/protocol.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

class EventLog {
 public:
  // Both must outlive it.
  EventLog(Clock& clock, RunSink& sink) : clock_(clock), sink_(sink) {}

  void event(EventName kind, std::string detail) const {
    if (closed_) return;
    sink_.event(RunEvent(clock_.now(), std::move(kind), step_id_, std::move(detail)));
  }
  template <EventPayload P>
  void event(const P& payload) const {
    if (closed_) return;
    sink_.event(RunEvent(clock_.now(), step_id_, payload));
  }
  // Events belong to this step until `end_step`.
  void begin_step(const Step& step) { step_id_ = step.id; }
  void end_step() { step_id_.clear(); }
  void close() {
    closed_ = true;
  }  // the run is over; nothing that happens from now on is part of it
  const std::string& step_id() const { return step_id_; }  // empty: between steps

 private:
  Clock& clock_;
  RunSink& sink_;
  std::string step_id_;
  bool closed_ = false;
};

}  // namespace lcrig
