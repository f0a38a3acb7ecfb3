// SPDX-License-Identifier: Apache-2.0
// The step `sweep`: runs its steps once for each value of a variable.
#pragma once

#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct SweepStep final : StepOf<SweepStep, Loop> {
  static constexpr std::string_view kWord = "sweep";
  std::string name;  // of the variable; its suffix gives the unit of the values
  std::vector<Number> values;  // from/to/count instead are expanded by the parser if they are
                               // literals
  std::optional<Number> from, to, count;

  using Progress = RemembersNothing;
  static SweepStep parse(const StepReader& r);
  std::int64_t passes(const Environment& env) const override;
  const Number* repeats() const override { return nullptr; }
  const std::string* variable() const override { return &name; }
  std::vector<const Number*> ends() const override;
  void set_variable(std::int64_t pass, Environment& env) const override;
};

}  // namespace lcrig
