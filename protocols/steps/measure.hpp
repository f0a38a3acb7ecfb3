// SPDX-License-Identifier: Apache-2.0
// The step `measure`: takes a number of fresh readings within a time. They form one level.
#pragma once

#include "protocols/load_level.hpp"
#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct MeasureStep final : StepOf<MeasureStep>, Readings {
  static constexpr std::string_view kWord = "measure";
  struct Progress : StepProgress {
    std::optional<LoadLevel> level;
    std::int64_t readings = 0;
    void go_on_from(const LeftOff& /*before*/) override {}
    void interrupt(MonoTime /*now*/) override {}
    void begin_again(RunParts& run) override;
  };
  static MeasureStep parse(const StepReader& r);
  StepFacts facts() const override {
    return {FrameUse::none(), this, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const override;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override;
};

}  // namespace lcrig
