// SPDX-License-Identifier: Apache-2.0
// The step `sweep`: runs its steps once for each value of a variable.
#pragma once

#include "protocols/steps/facts.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

struct SweepStep {
  static constexpr std::string_view kWord = "sweep";
  std::string name;  // of the variable; its suffix gives the unit of the values
  std::vector<Number> values;  // from/to/count instead are expanded by the parser if they are
                               // literals
  std::optional<Number> from, to, count;
  Steps steps;

  using Progress = RemembersNothing;
  static SweepStep parse(const StepReader& r);
  StepFacts facts() const {
    return {FrameUse::none(), kNoReadings, kNoSettings, kNoQuestion, Loop(*this)};
  }
  std::int64_t passes(const Environment& env) const;
  const Number* repeats() const { return nullptr; }
  const std::string* variable() const { return &name; }
  std::vector<const Number*> ends() const;
  void set_variable(std::int64_t pass, Environment& env) const;
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, Progress& progress) const;
};

}  // namespace lcrig
