// SPDX-License-Identifier: Apache-2.0
// Stops and pauses that take effect at the end of a step, a level, a cycle or a repeat. A protocol
// has no conditions, so a request is at once converted to a number of steps. Used by `Run`.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "protocols/run/event_log.hpp"
#include "protocols/stop_places.hpp"

namespace lcrig {

struct PlannedStop {
  StopPlace place = StopPlace::step;
  std::int64_t after_steps = 0;  // leaf steps that will be done then
  std::string step_id;  // the last of them
  std::string why;  // who asked, and why
};

class PlannedStops {
 public:
  enum class Kind { stop, pause };
  // The answer to a request.
  struct Asked {
    PlannedStop stop;  // the stop that applies now
    bool was_nearer = false;  // an earlier request applies, because it comes sooner
    std::optional<PlannedStop> replaces;  // an earlier request that would have come later
    double seconds = 0;  // planned time, after the current step
  };
  // Planned time of a step.
  using Planned = std::function<double(const std::string&)>;

  // Both must outlive it.
  PlannedStops(const Environment& environment, const EventLog& log)
      : places_(environment), log_(log) {}

  // While it lives, the steps of the protocol run.
  class Walk {
   public:
    Walk(PlannedStops& stops, const StepCursor& cursor, bool continues);
    ~Walk() { stops_.cursor_ = nullptr; }
    Walk(const Walk&) = delete;
    Walk& operator=(const Walk&) = delete;

   private:
    PlannedStops& stops_;
  };
  void enter(const Step& step);
  void leave(const Step& step);

  // The nearer of two requested places applies. Errors: invalid_request (no step runs, no safe
  // point follows).
  Result<Asked> ask(Kind kind, StopPlace place, std::string why, std::int64_t steps_done,
                    const Planned& planned_s);
  const std::optional<PlannedStop>& waiting(Kind kind) const {
    return kind == Kind::stop ? stop_ : pause_;
  }
  // Takes the stop or pause that is due before the next step.
  std::optional<PlannedStop> take_due(Kind kind, std::int64_t steps_done);

 private:
  std::optional<PlannedStop>& slot(Kind kind) { return kind == Kind::stop ? stop_ : pause_; }

  StopPlaces places_;
  const EventLog& log_;
  const StepCursor* cursor_ = nullptr;  // nullptr: no step of the protocol runs
  const Step* step_ = nullptr;  // the current step
  bool level_begun_ = false;  // a motion has been made since the last `measure`
  std::optional<PlannedStop> stop_, pause_;
};

}  // namespace lcrig
