// SPDX-License-Identifier: Apache-2.0
// The step `repeat`: runs its steps several times.
#pragma once

#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct RepeatStep final : StepOf<RepeatStep, Loop> {
  static constexpr std::string_view kWord = "repeat";
  Number count;

  using Progress = RemembersNothing;
  static RepeatStep parse(const StepReader& r);
  std::int64_t passes(const Environment& env) const override;
  const Number* repeats() const override { return &count; }
  const std::string* variable() const override { return nullptr; }
  std::vector<const Number*> ends() const override { return {}; }
  void set_variable(std::int64_t /*pass*/, Environment& /*env*/) const override {}
};

}  // namespace lcrig
