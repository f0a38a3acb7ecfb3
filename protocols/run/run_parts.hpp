// SPDX-License-Identifier: Apache-2.0
// The parts of one run, wired together. Steps, the recovery from a loss and the end of a run get
// them all, and use no more than the public side of each.
#pragma once

#include <cstdint>
#include <optional>

#include "protocols/run/contact_place.hpp"
#include "protocols/run/distrust.hpp"
#include "protocols/run/event_log.hpp"
#include "protocols/run/frame_drive.hpp"
#include "protocols/run/frame_truth.hpp"
#include "protocols/run/frame_view.hpp"
#include "protocols/run/interrupts.hpp"
#include "protocols/run/levels.hpp"
#include "protocols/run/motions.hpp"
#include "protocols/run/planned_stops.hpp"
#include "protocols/run/questions.hpp"
#include "protocols/run/sampler.hpp"
#include "protocols/run/setup.hpp"
#include "protocols/watch/guard.hpp"

namespace lcrig {

struct RunParts {
  // `look`: see InterruptQueue. `sampled`: who is told of the meter's readings.
  RunParts(asio::any_io_executor executor, RunSetup& s, std::function<void()> look,
           Sampler::Hooks sampled);

  const RunSetup& setup;  // clock, instruments, sink, and the values of the protocol's numbers
  Pressing* const pressing;  // nullptr: the frame cannot move
  RunProgress progress;  // as people see it
  EventLog log;
  InterruptQueue interrupts;
  Guard guard;
  FrameView view;
  FrameTruth truth;
  ContactPlace contact;
  FrameDrive drive;
  Distrust distrust;
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
  double get(const Number& number) const { return setup.environment.get(number); }
  // Nothing is pressed with a cell that says nothing; the way back needs the travel only.
  bool needs_force() const { return setup.moves() && !interrupts.finishing(); }
  // Where the run stands, to be stored: enough to go on there later.
  RunPoint point() const;
};

// What of a step survives a pause or a loss in the middle of it.
struct StepProgress {
  std::optional<MonoTime> begin;  // of the wait that goes on now
  Duration spent{};  // of waits before it
  std::int64_t readings = 0;
  std::optional<LoadLevel> level;
  bool moved = false;
  bool answered = false;  // a question
  std::optional<AnswerEvent> kept_answer;  // ... of the run that this one continues
  std::optional<double> start_travel_m;  // where a search for contact began
  std::optional<double> away_m;  // where the way back without a contact leads
  // The step does not go on now; the time until it does again is not its own.
  void interrupt(MonoTime now) {
    if (begin) spent += now - *begin;
    begin.reset();
  }
};

// What several kinds of steps do: a motion to a travel or a gap, and a wait that survives a pause.
Task<Result<>> move_to_place(const Target& to, const Number& speed, const Number& timeout,
                             RunParts& run);
Task<Result<>> wait_out(double duration_s, RunParts& run, StepProgress& progress);

}  // namespace lcrig
