// SPDX-License-Identifier: Apache-2.0
// The facts that the kinds of steps state; parser, planner and runner ask for nothing else.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <type_traits>

#include "base/clock.hpp"
#include "protocols/expand.hpp"
#include "protocols/file/step_kinds.hpp"
#include "protocols/plan/planned_rig.hpp"
#include "protocols/protocol.hpp"
#include "tests/support/corpus.hpp"

namespace lcrig {
namespace {

Target at(TargetKind kind, double value) {
  Target out;
  out.kind = kind;
  out.value = Number(value);
  return out;
}

// A step that leaves out a fact does not compile.
static_assert(!std::is_default_constructible_v<StepFacts>);
static_assert(!std::is_default_constructible_v<FrameUse>);
static_assert(!std::is_constructible_v<StepFacts, FrameUse>);
// A motion that loads a cycle has a force and a speed.
static_assert(std::is_invocable_v<decltype(FrameUse::cycle), Target&, Number&, HoldMode>);
static_assert(!std::is_invocable_v<decltype(FrameUse::cycle), Target*, Number*, HoldMode>);

// A kind of step that remembers something has to say what happens to it. One that forgets a
// function is abstract, so it does not compile.
struct ForgetsToGoOn : StepProgress {
  void interrupt(MonoTime /*now*/) override {}
  void begin_again(RunParts& /*run*/) override {}
};
struct ForgetsInterrupts : StepProgress {
  void go_on_from(const LeftOff& /*before*/) override {}
  void begin_again(RunParts& /*run*/) override {}
};
struct ForgetsToBeginAgain : StepProgress {
  void go_on_from(const LeftOff& /*before*/) override {}
  void interrupt(MonoTime /*now*/) override {}
};
static_assert(std::is_abstract_v<ForgetsToGoOn>);
static_assert(std::is_abstract_v<ForgetsInterrupts>);
static_assert(std::is_abstract_v<ForgetsToBeginAgain>);
static_assert(std::is_final_v<RemembersNothing> && std::is_final_v<RemembersTime>);

// The same holds for a kind that forgets one of its functions. The base is that of a whole kind:
// clang also compiles the functions of `StepOf` for a class whose being abstract is asked.
struct Whole : StepOf<Whole> {
  static constexpr std::string_view kWord = "whole";
  using Progress = RemembersNothing;
  StepFacts facts() const override {
    return {FrameUse::none(), kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& /*rig*/) const override { return {}; }
  Task<Result<>> execute(RunParts& /*run*/, StepProgress& /*remembered*/) const override {
    co_return Result<>();
  }
};
struct ForgetsFacts : StepOf<Whole> {
  StepPlan plan(PlannedRig& rig) const override { return Whole().plan(rig); }
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override {
    return Whole().execute(run, remembered);
  }
};
struct ForgetsToPlan : StepOf<Whole> {
  StepFacts facts() const override { return Whole().facts(); }
  Task<Result<>> execute(RunParts& run, StepProgress& remembered) const override {
    return Whole().execute(run, remembered);
  }
};
struct ForgetsToExecute : StepOf<Whole> {
  StepFacts facts() const override { return Whole().facts(); }
  StepPlan plan(PlannedRig& rig) const override { return Whole().plan(rig); }
};
static_assert(!std::is_abstract_v<Whole>);
static_assert(std::is_abstract_v<ForgetsFacts>);
static_assert(std::is_abstract_v<ForgetsToPlan>);
static_assert(std::is_abstract_v<ForgetsToExecute>);
// One that has neither a word nor a `Progress` is refused by StepOf, and one that cannot be parsed
// by the parser's table.
static_assert(std::is_abstract_v<StepOf<Whole>> && std::is_abstract_v<Loop>);

template <class Kind>
concept HasATime = requires(const Kind& step) { step.timeout; } || requires(const Kind& step) {
  step.duration;
} || requires(const Kind& step) { step.within; };
template <class... Kind>
constexpr bool those_with_a_time_remember(std::tuple<Kind...>* /*all*/) {
  return ((!HasATime<Kind> || !std::is_same_v<typename Kind::Progress, RemembersNothing>) && ...);
}
static_assert(those_with_a_time_remember(static_cast<StepKinds*>(nullptr)));

TEST(Steps, ALoopRunsAsOftenAsItCountsOrHasValues) {
  Environment environment;
  environment.set("n", 4);
  RepeatStep repeat;
  repeat.count = Number(3);
  EXPECT_EQ(repeat.facts().loop->passes(environment), 3);
  EXPECT_EQ(repeat.facts().loop->repeats(), &repeat.count);
  EXPECT_EQ(repeat.facts().loop->variable(), nullptr);
  SweepStep sweep;
  sweep.values = {Number(1), Number(2)};
  EXPECT_EQ(sweep.facts().loop->passes(environment), 2);
  EXPECT_EQ(sweep.facts().loop->repeats(), nullptr);
  EXPECT_EQ(sweep.facts().loop->variable(), &sweep.name);
  sweep.count.emplace();
  sweep.count->name = "n";
  EXPECT_EQ(sweep.facts().loop->passes(environment), 4);
}

TEST(Steps, KindsAreTheWordsOfTheFile) {
  Step step;
  step.action = std::make_shared<FindContactStep>();
  EXPECT_EQ(kind_of(step), "find_contact");
  step.action = std::make_shared<SetGapStep>();
  EXPECT_EQ(kind_of(step), "set_gap");
}

TEST(Steps, OnlyMotionsMove) {
  EXPECT_TRUE(FindContactStep().facts().moves);
  EXPECT_TRUE(RampStep().facts().moves);
  EXPECT_TRUE(MoveUntilStep().facts().moves);
  EXPECT_FALSE(HoldStep().facts().moves);
  EXPECT_FALSE(ZeroStep().facts().moves);
  EXPECT_FALSE(PlaceWeightStep().facts().moves);
  EXPECT_FALSE(SetGapStep().facts().moves);
}

TEST(Steps, AHeldTravelAsksNothingOfTheFrameAHeldForceDoes) {
  HoldStep hold;
  EXPECT_FALSE(hold.facts().commands_frame());
  hold.mode = HoldMode::force;
  EXPECT_TRUE(hold.facts().commands_frame());
  EXPECT_TRUE(ZeroStep().facts().commands_frame());
  EXPECT_FALSE(MeasureStep().facts().commands_frame());
  EXPECT_FALSE(PlaceWeightStep().facts().commands_frame());
}

TEST(Steps, ARampLeavesTheControlThatItUsed) {
  RampStep ramp;
  ramp.to = at(TargetKind::force, 1);
  ramp.force_rate = Number(0.1);
  EXPECT_EQ(ramp.facts().leaves, HoldMode::force);
  EXPECT_EQ(ramp.facts().speed, nullptr);
  ramp.speed = Number(1e-3);
  EXPECT_EQ(ramp.facts().leaves, HoldMode::travel);
  EXPECT_EQ(ramp.facts().speed->value, 1e-3);
  EXPECT_EQ(ramp.facts().aim->kind, TargetKind::force);
}

TEST(Steps, OnlyAMotionToAForceLoadsACycle) {
  MoveUntilStep move;
  move.until = at(TargetKind::travel, 1e-3);
  EXPECT_EQ(move.facts().frame_use, FrameUse::Kind::motion);
  move.until = at(TargetKind::pressure, 1e4);
  EXPECT_EQ(move.facts().frame_use, FrameUse::Kind::cycle);
  EXPECT_TRUE(move.facts().moves);
}

TEST(Steps, WhatNeedsTheMeterSaysSo) {
  EXPECT_TRUE(MeasureStep().facts().needs_meter());
  EXPECT_TRUE(SetLcrStep().facts().needs_meter());
  EXPECT_FALSE(RecordStep().facts().needs_meter());
}

TEST(Steps, ATargetIsAForceByAreaOrGravity) {
  Environment env;
  const LoadFactors factors(2e-4, 9.8);
  EXPECT_EQ(target_force_N(at(TargetKind::force, 3), env, factors), 3);
  EXPECT_EQ(target_force_N(at(TargetKind::pressure, 1e4), env, factors), 2);
  EXPECT_EQ(target_force_N(at(TargetKind::mass, 0.5), env, factors), 4.9);
  EXPECT_TRUE(is_force(at(TargetKind::mass, 0.5)));
  EXPECT_FALSE(is_force(at(TargetKind::gap, 0.5)));
}

// Once the planner forgot the interval here and the runner kept it.
TEST(Steps, AMeterThatIsAskedForEachReadingIsNotPolled) {
  Environment env;
  LcrSettings settings;
  settings.trigger = LcrTrigger::internal;
  settings.poll_interval = std::chrono::milliseconds(10);
  SetLcrStep step;
  step.average = Number(4);
  EXPECT_EQ(step.change(settings, env).poll_interval, settings.poll_interval);
  EXPECT_EQ(step.change(settings, env).average, 4);
  step.trigger = LcrTrigger::bus;
  EXPECT_FALSE(step.change(settings, env).poll_interval);
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// For authors of a new step: checks what the compiler cannot. A file of the corpus that uses the
// step makes check_schema.py try its whole schema.
TEST(Steps, EveryKindIsInTheSchemaTheCorpusAndOnThePageOfTheProtocolFile) {
  const std::string schema = text_of("schema/protocol.schema.json");
  const std::string page = text_of("docs/protocol-file.md");
  std::string accepted;
  for (const auto& file : corpus::files("tests/corpus/protocol/accept")) accepted += text_of(file);
  const auto look_for = [&]<class... Kind>(std::tuple<Kind...>*) {
    for (const std::string_view word : {Kind::kWord...}) {
      EXPECT_NE(schema.find(fmt::format("\"const\": \"{}\"", word)), schema.npos) << word;
      EXPECT_NE(accepted.find(fmt::format("\"do\": \"{}\"", word)), accepted.npos) << word;
      EXPECT_NE(page.find(fmt::format("\n| `{}` |", word)), page.npos) << word;
    }
  };
  look_for(static_cast<StepKinds*>(nullptr));
}

}  // namespace
}  // namespace lcrig
