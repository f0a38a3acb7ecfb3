// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/planned_stops.hpp"

#include <fmt/format.h>

#include <utility>

namespace lcrig {

PlannedStops::Walk::Walk(PlannedStops& stops, const StepCursor& cursor, bool continues)
    : stops_(stops) {
  stops.cursor_ = &cursor;
  stops.step_ = nullptr;
  // The steps before the interruption may have contained the motion of a level.
  stops.level_begun_ = continues;
}

void PlannedStops::enter(const Step& step) {
  if (cursor_ == nullptr) return;
  step_ = &step;
  level_begun_ = level_begun_ || begins_level(step);
}

void PlannedStops::leave(const Step& step) {
  if (facts_of(step).measures != nullptr) level_begun_ = false;
}

Result<PlannedStops::Asked> PlannedStops::ask(Kind kind, StopPlace place, std::string why,
                                              std::int64_t steps_done, const Planned& planned_s) {
  if (cursor_ == nullptr || step_ == nullptr) {
    return fail(Errc::invalid_request,
                "no step of the protocol runs yet, so none can be finished: `lcrig abort` ends the "
                "run before it begins");
  }
  const auto ahead = places_.ahead(place, *cursor_, *step_, level_begun_, planned_s);
  if (!ahead) {
    return fail(Errc::invalid_request,
                "no step behind step {} is marked as a safe point: expected one of step, level, "
                "cycle, repeat",
                step_->id);
  }
  Asked out;
  out.seconds = ahead->seconds;
  out.stop = PlannedStop{place, steps_done + ahead->steps, ahead->step_id, std::move(why)};
  auto& waiting = slot(kind);
  if (waiting && waiting->after_steps <= out.stop.after_steps) {
    out.stop = *waiting;
    out.was_nearer = true;
    return out;
  }
  out.replaces = std::exchange(waiting, out.stop);
  if (kind == Kind::stop) {
    log_.event(StopAfterEvent{std::string(to_string(place)), ahead->step_id, out.stop.after_steps,
                              out.stop.why});
  } else {
    log_.event(PauseAtEvent{std::string(to_string(place)), ahead->step_id, out.stop.after_steps,
                            out.stop.why});
  }
  return out;
}

std::optional<PlannedStop> PlannedStops::take_due(Kind kind, std::int64_t steps_done) {
  auto& waiting = slot(kind);
  if (!waiting || steps_done < waiting->after_steps) return std::nullopt;
  return std::exchange(waiting, std::nullopt);
}

}  // namespace lcrig
