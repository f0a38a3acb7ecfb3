// SPDX-License-Identifier: Apache-2.0
// What a step remembers while it runs, so that it can continue after an interrupt. Each kind of
// step defines its own `Progress`; the run keeps the object until the step ends.
#pragma once

#include <algorithm>
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

// A kind of step has to state all three, so a new one that forgets one does not compile.
struct StepProgress {
  StepProgress() = default;
  StepProgress(const StepProgress&) = delete;
  StepProgress& operator=(const StepProgress&) = delete;
  virtual ~StepProgress() = default;
  // Called if the interrupted run was cut off in this step.
  virtual void go_on_from(const LeftOff& before) = 0;
  // Called when the step is interrupted: the time until it continues does not count for it.
  virtual void interrupt(MonoTime now) = 0;
  // Called after a loss, when the step begins again instead of continuing.
  virtual void begin_again(RunParts& run) = 0;
};

// For steps that start from the beginning after each interrupt.
struct RemembersNothing final : StepProgress {
  void go_on_from(const LeftOff& /*before*/) override {}
  void interrupt(MonoTime /*now*/) override {}
  void begin_again(RunParts& /*run*/) override {}
};

// The time that a step has spent waiting or moving, as its duration and its time-out count it.
class TimeSpent {
 public:
  // Counts from now on. Returns the instant when `whole` will be spent; `now` if it is spent.
  MonoTime begin(MonoTime now, Duration whole) {
    end(now);
    begun_ = now;
    return now + std::max(Duration::zero(), whole - spent_);
  }
  void end(MonoTime now) {
    if (begun_) spent_ += now - *begun_;
    begun_.reset();
  }
  void forget() { *this = TimeSpent(); }

 private:
  std::optional<MonoTime> begun_;
  Duration spent_{};
};

// For steps that remember only their time.
struct RemembersTime final : StepProgress {
  TimeSpent time;
  void go_on_from(const LeftOff& /*before*/) override {}
  void interrupt(MonoTime now) override { time.end(now); }
  void begin_again(RunParts& /*run*/) override { time.forget(); }
};

}  // namespace lcrig
