// SPDX-License-Identifier: Apache-2.0
// A rehearsal with a fault script: the run records what happened, and a repetition is the same.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/rehearse.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using ::testing::HasSubstr;

constexpr const char* kRehearsed =
    R"({ "format": "load-protocol/1", "name": "drill", "on_loss": "wait",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
      "frame": { "rate_Hz": 50 } },
  "steps": [ { "id": "watch", "do": "record", "for_s": 20 },
             { "id": "level", "do": "measure", "count": 5, "within_s": 5 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 1, "timeout_s": 6 } ] })";

class RehearseFaults : public ::testing::Test {
 protected:
  RehearseRequest request(const std::string& faults) const {
    RehearseRequest r;
    r.protocol_name = "drill";
    r.protocol_text = kRehearsed;
    r.specimen_name = "paper-1";
    r.specimen_text = std::string(shipped_specimens().front().text);
    r.db_path = dir.file("r.db");
    r.faults_name = "drill.json";
    r.faults_text = R"({ "format": "faults/1", "seed": 3, "faults": [)" + faults + "] }";
    return r;
  }
  // Times and texts of the faults injected into a run, one per line.
  std::string injected(std::int64_t run) const {
    const auto db = open_read_only(dir.file("r.db")).value();
    auto row = db.prepare(
                     "SELECT e.at_mono_ns - r.started_mono_ns, e.step_id, e.detail FROM event "
                     "e JOIN run r ON r.id = e.run_id WHERE e.kind = 'injected' AND r.id = " +
                     std::to_string(run) + " ORDER BY e.seq")
                   .value();
    std::string out;
    while (row.step().value()) {
      out += fmt::format("{} {} {}\n", row.integer(0), row.text(1), row.text(2));
    }
    return out;
  }
  TempDir dir;
};

TEST_F(RehearseFaults, WhatHappenedStandsInTheRunAndHappensAgainTheSameWay) {
  const auto wanted = request(R"(
    { "fault": "reply_lost", "on": "meter", "probability": 0.02 },
    { "fault": "unplug", "on": "frame", "at_s": 5, "for_s": 1 },
    { "fault": "force_spike", "on": "frame", "in_step": "level", "after_s": 1, "force_N": 0.2 })");
  const auto first = rehearse(wanted);
  ASSERT_TRUE(first) << first.error().what;
  EXPECT_EQ(first->exit_status, ExitStatus::success) << first->reason;
  EXPECT_GE(first->faults, 3);
  const std::string told = injected(first->run);
  EXPECT_THAT(told, HasSubstr("5000000000 watch fault injected: frame unplug\n"));
  EXPECT_THAT(told, HasSubstr("watch fault injected: frame unplug: over\n"));
  EXPECT_THAT(told, HasSubstr("level fault injected: frame force_spike, force_N 0.2, samples 1\n"));
  EXPECT_THAT(told, HasSubstr("fault injected: meter reply_lost\n"));
  const auto second = rehearse(wanted);
  ASSERT_TRUE(second) << second.error().what;
  EXPECT_EQ(injected(second->run), told);
}

TEST_F(RehearseFaults, AWrongScriptIsRefusedAndNothingIsStored) {
  const auto wrong = rehearse(request(R"({ "fault": "stal", "on": "frame", "at_s": 1 })"));
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, Errc::invalid_request);
  EXPECT_THAT(wrong.error().what, HasSubstr("/faults/0/fault"));
  EXPECT_THAT(wrong.error().what, HasSubstr("did you mean `stall`"));
  EXPECT_FALSE(std::filesystem::exists(dir.file("r.db")));
}

TEST_F(RehearseFaults, AReplayHasNoBenchThatCouldGoWrong) {
  auto wanted = request(R"({ "fault": "stall", "on": "frame", "at_s": 1 })");
  wanted.bench = "replay:" + dir.path().string();
  const auto refused = rehearse(wanted);
  ASSERT_FALSE(refused);
}

}  // namespace
}  // namespace lcrig
