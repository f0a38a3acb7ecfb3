// SPDX-License-Identifier: Apache-2.0
// Memory of a step while it runs, so that it goes on where it was interrupted. Each kind of step
// has a `Progress` with what it needs; the run keeps it for as long as the step runs.
#pragma once

#include <optional>

#include "base/time.hpp"
#include "events/payloads.hpp"

namespace lcrig {

struct RunParts;  // run/run_parts.hpp

// Memory of the step in which the run that this one continues was cut off.
struct LeftOff {
  std::optional<double> start_travel_m;  // of the frame, when the step began
  std::optional<AnswerEvent> answer;  // to its question
};

// For a step that has nothing to remember.
struct StepProgress {
  StepProgress() = default;
  StepProgress(const StepProgress&) = delete;
  StepProgress& operator=(const StepProgress&) = delete;
  virtual ~StepProgress() = default;
  // The run that this one continues was cut off in this step. By default the step begins as if it
  // had never run.
  virtual void go_on_from(const LeftOff& /*before*/) {}
  // The step does not go on now; the time until it does again is not its own. By default nothing
  // changes: a step that measures time from a moment that it keeps here has to override it.
  virtual void interrupt(MonoTime /*now*/) {}
  // After a loss it does not go on but begins anew. By default nothing is forgotten: a step that
  // keeps what it has done here has to override it, or it takes up where it was.
  virtual void begin_again(RunParts& /*run*/) {}
};

// For a step that waits for a time.
struct WaitProgress : StepProgress {
  std::optional<MonoTime> begin;  // of the wait that goes on now
  Duration spent{};  // in waits before it

  void interrupt(MonoTime now) override {
    if (begin) spent += now - *begin;
    begin.reset();
  }
  void begin_again(RunParts& /*run*/) override {
    begin.reset();
    spent = Duration::zero();
  }
};

}  // namespace lcrig
