// SPDX-License-Identifier: Apache-2.0
// A simulated person who answers questions: with the answer given for the rehearsal, else with the
// protocol's default, else with something that fits. The row of the answer says which. Used by the
// simulated bench and by recordings.
#pragma once

#include <functional>
#include <utility>

#include "base/time.hpp"
#include "daemon/rig/answers.hpp"
#include "protocols/run/questions.hpp"

namespace lcrig {

class SimRespondent final : public Respondent {
 public:
  // Answers after `delay`, or when the person is back. `clock` must outlive it.
  SimRespondent(Clock& clock, Duration delay, std::function<bool()> is_absent, Answers answers)
      : clock_(clock),
        delay_(delay),
        is_absent_(std::move(is_absent)),
        answers_(std::move(answers)) {}
  Task<Result<GivenAnswer>> answer(Question question) override;

 private:
  Result<GivenAnswer> choose(const Question& question) const;

  Clock& clock_;
  Duration delay_;
  std::function<bool()> is_absent_;
  Answers answers_;
};

}  // namespace lcrig
