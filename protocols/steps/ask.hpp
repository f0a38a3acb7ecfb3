// SPDX-License-Identifier: Apache-2.0
// The step `ask`: asks a person and stores the answer. The frame stands while it waits.
#pragma once

#include <string>

#include "protocols/question.hpp"
#include "protocols/steps/progress.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct AskStep final : StepOf<AskStep>, StepQuestion {
  static constexpr std::string_view kWord = "ask";
  std::string text;
  AnswerType type = AnswerType::confirmation;
  std::vector<std::string> choices;
  std::string unit;  // for a number: suffix of its range; empty: a pure number
  double to_si = 1;  // factor of that suffix
  std::optional<Number> min, max;  // for a number, SI
  std::optional<Number> default_number;  // SI
  std::optional<std::string> default_text;  // for a choice or a line
  Number timeout;  // s
  OnTimeout on_timeout = OnTimeout::abort;

  struct Progress : StepProgress {
    TimeSpent time;
    bool answered = false;  // survives an interrupt, so that nobody is asked twice
    std::optional<AnswerEvent> kept_answer;  // from the run that this one continues
    void go_on_from(const LeftOff& before) override { kept_answer = before.answer; }
    void interrupt(MonoTime now) override { time.end(now); }
    void begin_again(RunParts& /*run*/) override { time.forget(); }
  };
  static AskStep parse(const StepReader& r);
  StepFacts facts() const override {
    return {FrameUse::none(), kNoReadings, kNoSettings, this, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const override;
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override;

  Question question(const std::string& step_id, const Environment& environment) const override;
  bool is_known(const Environment& environment) const override;
};

}  // namespace lcrig
