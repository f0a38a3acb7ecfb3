// SPDX-License-Identifier: Apache-2.0
// Stops and pauses that take effect at the end of a step, a level, a cycle or a repeat. A protocol
// has no conditions, so that end is known as soon as somebody asks: a number of steps. `Run` uses
// it.
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
  std::int64_t after_steps = 0;  // leaf steps that are done then
  std::string step_id;  // the last of them
  std::string why;  // who asked, and why
};

class PlannedStops {
 public:
  enum class Kind { stop, pause };
  // Result of a request.
  struct Asked {
    PlannedStop stop;  // what counts now
    bool was_nearer = false;  // it is one that had been asked for before, and comes earlier
    std::optional<PlannedStop> replaces;  // one that would have come later
    double seconds = 0;  // planned, behind the present step
  };
  // Planned time of a step.
  using Planned = std::function<double(const std::string&)>;

  // Both outlive it.
  PlannedStops(const Environment& environment, const EventLog& log)
      : places_(environment), log_(log) {}

  // The steps of the protocol run, `done` of them are done; the end of this scope ends that.
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

  // The nearer of two places counts. Errors: invalid_request (no step runs, no safe point follows).
  Result<Asked> ask(Kind kind, StopPlace place, std::string why, std::int64_t steps_done,
                    const Planned& planned_s);
  const std::optional<PlannedStop>& waiting(Kind kind) const {
    return kind == Kind::stop ? stop_ : pause_;
  }
  // The one that waits for no further step.
  std::optional<PlannedStop> take_due(Kind kind, std::int64_t steps_done);

 private:
  std::optional<PlannedStop>& slot(Kind kind) { return kind == Kind::stop ? stop_ : pause_; }

  StopPlaces places_;
  const EventLog& log_;
  const StepCursor* cursor_ = nullptr;  // nullptr: no step of the protocol runs
  const Step* step_ = nullptr;  // that runs
  bool level_begun_ = false;  // a motion was made since the last `measure`
  std::optional<PlannedStop> stop_, pause_;
};

}  // namespace lcrig
