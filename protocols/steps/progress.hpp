// SPDX-License-Identifier: Apache-2.0
// What a step remembers while it runs, so that it can continue after an interrupt. Each kind of
// step defines its own `Progress`; the run keeps the object until the step ends.
#pragma once

#include <optional>

#include "base/time.hpp"
#include "events/payloads.hpp"

namespace lcrig {

struct RunParts;  // run/run_parts.hpp

// What is known about the step in which the interrupted run was cut off. This run continues it.
struct LeftOff {
  std::optional<double> start_travel_m;  // of the frame at the start of the step
  std::optional<AnswerEvent> answer;  // the answer to its question
};

// The base class; also used by steps that remember nothing.
struct StepProgress {
  StepProgress() = default;
  StepProgress(const StepProgress&) = delete;
  StepProgress& operator=(const StepProgress&) = delete;
  virtual ~StepProgress() = default;
  // Called if the interrupted run was cut off in this step. By default the step starts from the
  // beginning.
  virtual void go_on_from(const LeftOff& /*before*/) {}
  // Called when the step is interrupted: the time until it continues does not count for it. By
  // default does nothing. A step that stores a start time here must override it.
  virtual void interrupt(MonoTime /*now*/) {}
  // Called after a loss, when the step begins again. By default does nothing. A step that stores
  // what it has done must override it; otherwise it would continue.
  virtual void begin_again(RunParts& /*run*/) {}
};

// Base class for steps that wait for a time.
struct WaitProgress : StepProgress {
  std::optional<MonoTime> begin;  // start of the current wait
  Duration spent{};  // in earlier waits

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
