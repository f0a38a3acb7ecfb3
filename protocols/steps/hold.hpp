// SPDX-License-Identifier: Apache-2.0
// The step `hold`: holds travel or force for a time.
#pragma once

#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct HoldStep final : StepOf<HoldStep> {
  static constexpr std::string_view kWord = "hold";
  HoldMode mode = HoldMode::travel;
  std::optional<Target> at;  // force or pressure to hold; absent: the present state
  Number duration;  // s; the frame goes on holding until the next motion

  struct Progress : StepProgress {
    TimeSpent time;
    bool holds = false;
    void go_on_from(const LeftOff& /*before*/) override {}
    void interrupt(MonoTime now) override { time.end(now); }
    void begin_again(RunParts& /*run*/) override {
      time.forget();
      holds = false;
    }
  };
  static HoldStep parse(const StepReader& r);
  StepFacts facts() const override {
    return {FrameUse::hold(mode, at ? &*at : nullptr), kNoReadings, kNoSettings, kNoQuestion,
            kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const override;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override;
};

}  // namespace lcrig
