// SPDX-License-Identifier: Apache-2.0
// The parts of one run, wired together. Each part knows only the parts that it uses. Steps, the
// recovery from a loss, the take-over of another run and the end of a run use all of them.
#pragma once

#include <memory>

#include "protocols/run/event_log.hpp"
#include "protocols/run/frame_drive.hpp"
#include "protocols/run/interrupts.hpp"
#include "protocols/run/levels.hpp"
#include "protocols/run/motions.hpp"
#include "protocols/run/planned_stops.hpp"
#include "protocols/run/progress_keeper.hpp"
#include "protocols/run/questions.hpp"
#include "protocols/run/response.hpp"
#include "protocols/run/rest_meter.hpp"
#include "protocols/run/sampler.hpp"
#include "protocols/run/setup.hpp"
#include "protocols/run/standstill.hpp"

namespace lcrig {

class FrameWatch;
class RigState;

struct RunParts {
  // `s` and `v` must outlive it. `look`: see InterruptQueue. `sampled`: who gets the meter's
  // readings.
  RunParts(asio::any_io_executor executor, RunSetup& s, const Environment& v,
           std::function<void()> look, Sampler::Hooks sampled);
  ~RunParts();

  const RunSetup& setup;  // clock, instruments, sink
  const Environment& values;  // parameters, and the sweep variables of the current step
  StandstillWatch still;
  ProgressKeeper progress;
  EventLog log;
  InterruptQueue interrupts;
  const std::unique_ptr<FrameWatch> watch_owner;  // few steps need to know what it is
  FrameWatch& watch;
  const RigState& rig;  // of the watch, as everybody may read it
  RestMeter meter;
  FrameDrive drive;
  Responses response;
  Motions motions;
  LevelLabels labels;
  Sampler sampler;
  Questions questions;
  PlannedStops stops;

  void event(EventName kind, std::string detail) const {
    log.event(std::move(kind), std::move(detail));
  }
  template <EventPayload P>
  void event(const P& payload) const {
    log.event(payload);
  }
  double get(const Number& number) const { return values.get(number); }
  // True while motions may press, which requires a cell that sends a force. The way back requires
  // only the travel.
  bool needs_force() const { return setup.moves() && !interrupts.finishing(); }
  // The only way into a state in which the run waits: returns once the frame stands. Until then the
  // state is `stopping`, STOP is repeated, and after a second it is an alarm.
  Task<ProgressKeeper::Shown> wait_as(RunState state);
  // The same for a step that waits for a person, within the time of the step: nobody can be asked
  // before the frame stands, and a run that nobody watches must end. Errors: not_standing.
  Task<Result<ProgressKeeper::Shown>> wait_for_person(MonoTime until);
  // The state of the run to be stored, from which it can be continued.
  RunPoint point() const;
};

// Actions shared by several kinds of steps: a motion to a travel or gap, and a wait that continues
// after a pause.
Task<Result<>> move_to_place(const Target& to, const Number& speed, TimeLimit limit, RunParts& run);
// Machine travel of a target in travel or gap. Errors: invalid_request without a contact.
Result<double> travel_of(const Target& target, const RunParts& run);
Task<Result<>> wait_out(double duration_s, RunParts& run, TimeSpent& time);

}  // namespace lcrig
