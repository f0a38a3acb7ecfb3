// SPDX-License-Identifier: Apache-2.0
// A simulated person who confirms prompts. Used by simulated rigs and tests.
#pragma once

#include <functional>
#include <string>

#include "base/time.hpp"
#include "drivers/load_frame.hpp"

namespace lcrig {

// Confirms every prompt after `delay`. Just before that it calls `act`, which does what the prompt
// asks for: with dead weights, plant.put_load(clock.now(), frame.pending_force().si()).
class SimOperator final : public Operator {
 public:
  SimOperator(Clock& clock, Duration delay) : clock_(clock), delay_(delay) {}
  // While the person is absent, prompts stay open. After returning the person confirms within a
  // second.
  void set_absent(bool absent) { absent_ = absent; }
  bool is_absent() const { return absent_; }
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
