// SPDX-License-Identifier: Apache-2.0
// Continues an interrupted run in this one, at the step where it stopped, once a person has looked
// at the specimen and if the frame is still where it was. `Run` uses it before its first step.
#pragma once

#include <optional>

#include "protocols/expand.hpp"
#include "protocols/run/interrupts.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

class TakeOver {
 public:
  explicit TakeOver(RunParts& run) : run_(run) {}

  // Asks a person to look, because the specimen may have been touched meanwhile. nullopt: go on.
  Task<std::optional<InterruptRequest>> confirm_specimen();
  // A person was asked and has not said that the specimen was not touched.
  bool unconfirmed() const { return unconfirmed_; }
  // Walks past the steps that were done, so that targets, settings and control modes are as they
  // were. Errors: the frame is not where it was, or an instrument does not answer.
  Task<Result<>> pass_done_steps(StepCursor& cursor);
  // Memory of the interrupted step. Only the first call returns it: it is of no use to later steps.
  LeftOff take_left_off() { return std::exchange(left_off_, {}); }

 private:
  Result<> compare_frame_at(std::int64_t first_step) const;
  void pass_over(const Step& step, LcrSettings& settings);
  void keep_answer(std::size_t which);

  RunParts& run_;
  bool unconfirmed_ = false;
  LeftOff left_off_;
  std::size_t asked_ = 0;  // questions of the steps that were passed
};

}  // namespace lcrig
