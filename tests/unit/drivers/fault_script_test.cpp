// SPDX-License-Identifier: Apache-2.0
#include "drivers/faults/script.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/corpus.hpp"

namespace lcrig {
namespace {

using ::testing::HasSubstr;

FaultScript script_of(const std::string& faults) {
  auto script = parse_fault_script(R"({ "format": "faults/1", "faults": [)" + faults + "] }", "f");
  if (!script) throw std::runtime_error(script.error().what);
  return std::move(*script);
}

TEST(FaultScriptCorpus, EveryBadFileIsRefusedWithPointerAndReason) {
  corpus::expect_all_refused("tests/corpus/faults/reject", 22, parse_fault_script);
}

TEST(FaultScriptCorpus, EveryGoodFileIsAccepted) {
  const auto good = corpus::files("tests/corpus/faults/accept");
  EXPECT_GE(good.size(), 3U);
  for (const auto& path : good) {
    const auto script = load_fault_script(path);
    EXPECT_TRUE(script) << script.error().what;
  }
}

TEST(FaultScript, ABareTimeMeansTheNextEventFromThenOn) {
  const auto script = script_of(R"({ "fault": "reply_lost", "on": "meter", "at_s": 5 },
    { "fault": "reply_lost", "on": "meter", "at_s": 5, "for_s": 2 },
    { "fault": "reply_lost", "on": "meter", "every": 20 })");
  EXPECT_EQ(script.faults[0].times, 1);
  EXPECT_FALSE(script.faults[1].times) << "all of two seconds";
  EXPECT_FALSE(script.faults[2].times) << "for ever";
}

TEST(FaultScript, AFaultSaysWhatItIs) {
  const auto script =
      script_of(R"({ "fault": "reply_late", "on": "meter", "every": 20, "delay_s": 1.5 })");
  EXPECT_EQ(describe(script.faults[0]), "meter reply_late, delay_s 1.5");
  const auto lies = script_of(R"({ "fault": "creep", "on": "frame", "at_s": 1, "speed_um_s": -5 },
    { "fault": "force_drift", "on": "frame", "at_s": 1, "rate_N_s": 0.005 },
    { "fault": "tare_lost", "on": "frame", "at_s": 1, "origin_changes": true })");
  EXPECT_EQ(describe(lies.faults[0]), "frame creep, speed_um_s -5");
  EXPECT_EQ(describe(lies.faults[1]), "frame force_drift, rate_N_s 0.005");
  EXPECT_EQ(describe(lies.faults[2]), "frame tare_lost, origin_changes");
}

TEST(FaultScript, WhatAStageCannotPlayIsRefusedWithItsPlace) {
  FaultStage simulator;
  simulator.knows_steps = simulator.has_surroundings = false;
  const auto step = check_stage(
      script_of(R"({ "fault": "stall", "on": "frame", "in_step": "load" })"), simulator);
  ASSERT_FALSE(step);
  EXPECT_THAT(step.error().what, HasSubstr("f:1:"));
  EXPECT_THAT(step.error().what, HasSubstr("/faults/0/in_step"));
  const auto disk =
      check_stage(script_of(R"({ "fault": "disk_full", "on": "bench", "at_s": 1 })"), simulator);
  ASSERT_FALSE(disk);
  EXPECT_THAT(disk.error().what, HasSubstr("lcrig rehearse --faults"));
  FaultStage rod;
  rod.has_frame = false;
  EXPECT_FALSE(check_stage(script_of(R"({ "fault": "stall", "on": "frame", "at_s": 1 })"), rod));
  EXPECT_TRUE(check_stage(script_of(R"({ "fault": "stuck", "on": "meter", "at_s": 1 })"), rod));
}

}  // namespace
}  // namespace lcrig
