// SPDX-License-Identifier: Apache-2.0
// A run that was interrupted goes on in this one, at the step where it stopped: after a person has
// looked at the specimen, and if the frame is still where it was.
#pragma once

#include <optional>

#include "protocols/expand.hpp"
#include "protocols/run/interrupts.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

class TakeOver {
 public:
  explicit TakeOver(RunParts& run) : run_(run) {}

  // Nobody knows what happened to the specimen meanwhile: a person looks. nullopt: go on.
  Task<std::optional<InterruptRequest>> confirm_specimen();
  // A person was asked and has not said that the specimen was not touched.
  bool unconfirmed() const { return unconfirmed_; }
  // Walks past the steps that were done, so that targets, settings and control modes are as they
  // were. Errors: the frame is not where it was, or an instrument does not answer.
  Task<Result<>> pass_done_steps(StepCursor& cursor);
  // Where the frame stood when the interrupted step began. Only the first call returns it: it is of
  // no use to later steps.
  std::optional<double> take_start_travel_m() { return std::exchange(start_travel_m_, {}); }
  // What was answered to the question that is asked again now; known once.
  std::optional<AnswerEvent> take_kept_answer() { return std::exchange(kept_answer_, {}); }

 private:
  Result<> compare_frame_at(std::int64_t first_step) const;
  void pass_over(const Step& step, LcrSettings& settings);
  void keep_answer(std::size_t which);

  RunParts& run_;
  bool unconfirmed_ = false;
  std::optional<double> start_travel_m_;
  std::size_t asked_ = 0;  // questions of the steps that were passed
  std::optional<AnswerEvent> kept_answer_;
};

}  // namespace lcrig
