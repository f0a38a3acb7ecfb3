// SPDX-License-Identifier: Apache-2.0
// Where a run stands, as people see it. The run and its steps say it here, and nobody else writes
// it.
#pragma once

#include <cstdint>
#include <utility>

#include "protocols/run/setup.hpp"
#include "protocols/run/sink.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

class ProgressKeeper {
 public:
  explicit ProgressKeeper(const RunSetup& setup);

  const RunProgress& now() const { return progress_; }
  RunState state() const { return progress_.state; }
  std::int64_t steps_done() const { return progress_.steps_done; }

  void enter(RunState state) { progress_.state = state; }  // the next phase of the run
  void enter_repeat(std::int64_t repeat, std::int64_t repeats);
  void enter_step(const Step& step);
  void count_step() { ++progress_.steps_done; }  // one more is done

  // A state that lasts as long as this object, also when the coroutine in it is cancelled. Then
  // the state before it comes back.
  class During {
   public:
    During(ProgressKeeper& keeper, RunState state)
        : keeper_(keeper), before_(std::exchange(keeper.progress_.state, state)) {}
    ~During() { keeper_.progress_.state = before_; }
    During(const During&) = delete;
    During& operator=(const During&) = delete;

   private:
    ProgressKeeper& keeper_;
    const RunState before_;
  };

 private:
  RunProgress progress_;
};

}  // namespace lcrig
