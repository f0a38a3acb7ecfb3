// SPDX-License-Identifier: Apache-2.0
// The step `hold`: holds travel or force for a time.
#pragma once

#include "protocols/steps/facts.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

struct HoldStep {
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
  StepFacts facts() const {
    return {FrameUse::hold(mode, at ? &*at : nullptr), kNoReadings, kNoSettings, kNoQuestion,
            kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, Progress& progress) const;
};

}  // namespace lcrig
