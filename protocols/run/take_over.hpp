// SPDX-License-Identifier: Apache-2.0
// Continues an interrupted run in this one, at the interrupted step. A person must have looked at
// the specimen, and the frame must be where it was. Used by `Run` before its first step.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "base/result.hpp"
#include "base/task.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

class StepCursor;
struct InterruptRequest;
struct LcrSettings;
struct RunParts;
struct Step;

class TakeOver {
 public:
  explicit TakeOver(RunParts& run) : run_(run) {}

  // Asks a person to look at the specimen, because it may have been touched meanwhile. nullopt: go
  // on.
  Task<std::optional<InterruptRequest>> confirm_specimen();
  // A person was asked, and did not confirm that the specimen is untouched.
  bool unconfirmed() const { return unconfirmed_; }
  // Walks through the completed steps, so that targets, settings and control modes are as before.
  // Errors: the frame is not where it was, or an instrument does not answer.
  Task<Result<>> pass_done_steps(StepCursor& cursor);
  // What the interrupted step remembered. Only the first call returns it, because it is of no use
  // to later steps.
  LeftOff take_left_off() { return std::exchange(left_off_, {}); }

 private:
  Task<Result<>> ask_person();
  Result<> compare_frame_at(std::int64_t first_step) const;
  void pass_over(const Step& step, LcrSettings& settings);
  void keep_answer(std::size_t which);

  RunParts& run_;
  bool unconfirmed_ = false;
  LeftOff left_off_;
  std::size_t asked_ = 0;  // number of questions in the skipped steps
};

}  // namespace lcrig
