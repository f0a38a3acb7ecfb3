// SPDX-License-Identifier: Apache-2.0
// The step `measure`: takes a number of fresh readings within a time. They form one level.
#pragma once

#include "protocols/run/load_level.hpp"
#include "protocols/steps/facts.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

struct MeasureStep {
  static constexpr std::string_view kWord = "measure";
  Number count;  // fresh readings
  Number within;  // s

  struct Progress : StepProgress {
    std::optional<LoadLevel> level;
    std::int64_t readings = 0;
    void go_on_from(const LeftOff& /*before*/) override {}
    void interrupt(MonoTime /*now*/) override {}
    void begin_again(RunParts& run) override;
  };
  static MeasureStep parse(const StepReader& r);
  StepFacts facts() const { return {FrameUse::none(), this, kNoSettings, kNoQuestion, kNoLoop}; }
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, Progress& progress) const;
};

}  // namespace lcrig
