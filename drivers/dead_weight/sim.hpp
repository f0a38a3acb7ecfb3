// SPDX-License-Identifier: Apache-2.0
// A person for rehearsals.
#pragma once

#include <functional>
#include <string>

#include "drivers/load_frame.hpp"

namespace lcrig {

// Confirms every prompt after `delay`. `act` is called just before, to do what the prompt says:
// with dead weights, plant.put_load(clock.now(), frame.pending_force().si()).
class SimOperator final : public Operator {
 public:
  SimOperator(Clock& clock, Duration delay) : clock_(clock), delay_(delay) {}
  // While absent nobody confirms; who comes back looks at the prompt within a second.
  void set_absent(bool absent) { absent_ = absent; }
  void set_act(std::function<void(const std::string& prompt)> act) { act_ = std::move(act); }
  // Errors: aborted (cancelled).
  Task<Result<>> confirm(std::string prompt) override;
  const std::string& prompt() const override { return prompt_; }

 private:
  Clock& clock_;
  Duration delay_;
  bool absent_ = false;
  std::function<void(const std::string&)> act_;
  std::string prompt_;
};

}  // namespace lcrig
