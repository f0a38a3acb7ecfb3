// SPDX-License-Identifier: Apache-2.0
// The step `set_lcr`: changes the given settings of the meter and leaves the others.
#pragma once

#include "drivers/lcr_meter.hpp"
#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct SetLcrStep final : StepOf<SetLcrStep>, MeterChange {
  static constexpr std::string_view kWord = "set_lcr";
  std::optional<Number> frequency, level, bias, average;  // Hz, V, V, 1
  bool bias_off = false;
  std::optional<Aperture> aperture;
  std::optional<LcrFunction> function;
  std::optional<LcrTrigger> trigger;

  using Progress = RemembersNothing;
  static SetLcrStep parse(const StepReader& r);
  StepFacts facts() const override {
    return {FrameUse::none(), kNoReadings, this, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const override;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override;
  LcrSettings change(LcrSettings settings, const Environment& env) const override;
};

}  // namespace lcrig
