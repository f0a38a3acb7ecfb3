// SPDX-License-Identifier: Apache-2.0
// The state and progress of a run that people see. Only the run and its steps write it. A state in
// which the run waits needs the proof that the frame stands, and is shown only while that holds.
#pragma once

#include <cstdint>
#include <utility>

#include "protocols/run/setup.hpp"
#include "protocols/run/sink.hpp"
#include "protocols/run/standstill.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

// The proof that the frame stood after the last order. Only FrameDrive::stand_still gives it.
class Stands {
 private:
  friend class FrameDrive;
  Stands() = default;
};

class ProgressKeeper {
 public:
  // Both must outlive it.
  ProgressKeeper(const RunSetup& setup, const StandstillWatch& still)
      : clock_(setup.clock), still_(still) {
    progress_.run = setup.run;
    progress_.protocol = setup.protocol.name;
    progress_.specimen = setup.specimen;
    progress_.planned_s = setup.planned.total_s;
    progress_.left_s = setup.planned.total_s;
  }

  RunProgress now() const {
    RunProgress out = progress_;
    out.state = state();
    out.standstill = still_.at(clock_.now());
    return out;
  }
  RunState state() const {
    return waits(progress_.state) && !still_.holds() ? RunState::stopping : progress_.state;
  }
  std::int64_t steps_done() const { return progress_.steps_done; }

  template <RunState kState>
    requires(!waits(kState))
  void enter() {  // next phase of the run
    progress_.state = kState;
  }
  void enter_repeat(std::int64_t repeat, std::int64_t repeats) {
    progress_.repeat = repeat;
    progress_.repeats = repeats;
  }
  void enter_step(const Step& step) {
    progress_.step_id = step.id;
    progress_.step_kind = kind_of(step);
  }
  void count_step() { ++progress_.steps_done; }  // one more step is done

  // Shows a state while this object lives, and then the previous one again, even if the coroutine
  // is cancelled.
  class [[nodiscard]] Shown {
   public:
    Shown(Shown&& other) noexcept
        : keeper_(std::exchange(other.keeper_, nullptr)), before_(other.before_) {}
    Shown& operator=(Shown&&) = delete;
    ~Shown() {
      if (keeper_ != nullptr) keeper_->progress_.state = before_;
    }

   private:
    friend class ProgressKeeper;
    Shown(ProgressKeeper& keeper, RunState state)
        : keeper_(&keeper), before_(std::exchange(keeper.progress_.state, state)) {}
    ProgressKeeper* keeper_;
    RunState before_;
  };
  template <RunState kState>
    requires(!waits(kState))
  Shown show() {
    return Shown(*this, kState);
  }
  // For a state in which the run waits.
  Shown show(RunState state, const Stands& /*proof*/) { return Shown(*this, state); }

 private:
  Clock& clock_;
  const StandstillWatch& still_;
  RunProgress progress_;
};

}  // namespace lcrig
