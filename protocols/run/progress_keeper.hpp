// SPDX-License-Identifier: Apache-2.0
// The state and progress of a run that people see. Only the run and its steps write it.
#pragma once

#include <cstdint>
#include <utility>

#include "protocols/run/setup.hpp"
#include "protocols/run/sink.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

class ProgressKeeper {
 public:
  explicit ProgressKeeper(const RunSetup& setup) {
    progress_.run = setup.run;
    progress_.protocol = setup.protocol.name;
    progress_.specimen = setup.specimen;
    progress_.planned_s = setup.planned.total_s;
    progress_.left_s = setup.planned.total_s;
  }

  const RunProgress& now() const { return progress_; }
  RunState state() const { return progress_.state; }
  std::int64_t steps_done() const { return progress_.steps_done; }

  void enter(RunState state) { progress_.state = state; }  // next phase of the run
  void enter_repeat(std::int64_t repeat, std::int64_t repeats) {
    progress_.repeat = repeat;
    progress_.repeats = repeats;
  }
  void enter_step(const Step& step) {
    progress_.step_id = step.id;
    progress_.step_kind = kind_of(step);
  }
  void count_step() { ++progress_.steps_done; }  // one more step is done

  // Sets a state while this object lives, and then restores the previous one, even if the coroutine
  // is cancelled.
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
