// SPDX-License-Identifier: Apache-2.0
// Every cause that must hold the whole queue, in every phase of a run in which it can occur, under
// the most permissive terms: failures are skipped, and nobody need be present.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/zwick/sim.hpp"
#include "tests/support/queue_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::QueueWorld;

constexpr const char* kOther =
    R"("fault": "other_instrument", "for_s": 1, "identity": "LCR-6100,REV E8.13,OTHER0007,Good Will Instrument Co., Ltd.")";

struct HoldingCause {
  const char* name;
  const char* on;
  const char* fault;  // members of the script
  std::vector<std::string> causes;  // causes that the queue may name when it holds
  bool from_the_start = false;  // begins with the step; otherwise 0.3 s into it
};

const std::vector<HoldingCause>& causes() {
  static const std::vector<HoldingCause> all{
      {"not_standing", "frame", R"("fault": "stop_unconfirmed")", {"not_standing"}},
      {"stop_ignored", "frame", R"("fault": "stop_ignored")", {"not_standing"}},
      {"stop_silences", "frame", R"("fault": "stop_silences")", {"not_standing"}},
      {"left_loaded", "frame", R"("fault": "silent")", {"left_loaded", "not_standing"}},
      {"limit",
       "frame",
       R"("fault": "force_spike", "force_N": 3)",
       {"limit", "frame_fault", "left_loaded"}},
      {"estop", "frame", R"("fault": "estop")", {"frame_fault", "left_loaded"}},
      {"estop_1s", "frame", R"("fault": "estop", "for_s": 1)", {"frame_fault", "left_loaded"}},
      {"not_ready", "frame", R"("fault": "refusal")", {"frame_fault", "left_loaded"}, true},
      {"other_meter", "meter", kOther, {"other_instrument"}}};
  return all;
}

struct QueueCell {
  const HoldingCause* cause;
  const char* phase;
};

// Nothing is commanded while a level is measured. A run may end before a meter that disappeared in
// `finally` is looked for again. Then the next run makes the comparison (CausesAtTheStart).
bool can_happen(const HoldingCause& cause, std::string_view phase) {
  if (std::string_view(cause.name) == "other_meter") return phase != "finally";
  if (std::string_view(cause.name) != "not_ready") return true;
  return phase == "approach" || phase == "load" || phase == "unload" || phase == "finally";
}

std::vector<QueueCell> every_queue_cell() {
  std::vector<QueueCell> out;
  for (const HoldingCause& cause : causes()) {
    for (const char* phase : {"approach", "load", "hold", "measure", "unload", "finally"}) {
      if (can_happen(cause, phase)) out.push_back({&cause, phase});
    }
  }
  return out;
}

class HeldQueue : public QueueWorld {
 protected:
  // Queues two entries, of which the first gets into trouble. However long it takes, no other
  // begins.
  void expect_held(const std::vector<std::string>& causes) {
    queue_up({"paper-1", "paper-1"}, {{"unattended", true}, {"on_failure", "skip"}});
    ok("queue.start");
    ASSERT_TRUE(until_gate("specimen"));
    ok("queue.answer", {{"text", "paper-1"}});
    ASSERT_TRUE(until_held());
    const json held = queue();
    EXPECT_THAT(causes, testing::Contains(held["cause"].get<std::string>())) << held;
    EXPECT_NE(held["why"], "");
    clock.run_for(io, 2h);
    EXPECT_EQ(queue()["going"], false);
    EXPECT_EQ(count("SELECT count(*) FROM queue_attempt WHERE entry_id = 2"), 0);
    EXPECT_EQ(state(2), "waiting");
  }
};

class EveryCause : public HeldQueue, public testing::WithParamInterface<QueueCell> {};

TEST_P(EveryCause, HoldsTheQueueWhateverTheTerms) {
  const auto& [cause, phase] = GetParam();
  troubles[1].script = fmt::format(
      R"({{ "format": "faults/1", "seed": 5, "faults": [ {{ "on": "{}", "in_step": "{}", "after_s": {}, {} }} ] }})",
      cause->on, phase, cause->from_the_start ? 0 : 0.3, cause->fault);
  ASSERT_NO_FATAL_FAILURE(expect_held(cause->causes));
  EXPECT_EQ(runs(), 1);
}

INSTANTIATE_TEST_SUITE_P(QueueMatrix, EveryCause, testing::ValuesIn(every_queue_cell()),
                         [](const auto& i) {
                           return std::string(i.param.cause->name) + "_" + i.param.phase;
                         });

using CausesAtTheStart = HeldQueue;

TEST_F(CausesAtTheStart, AFrameThatIsNotReadyHolds) {
  troubles[1].at_start = [](Instruments& rig) {
    rig.door()->break_frame([](ZwickSimFaults& faults) { faults.not_ready = true; });
  };
  expect_held({"frame_fault"});
}

TEST_F(CausesAtTheStart, AFrameThatDoesNotOpenBecauseItDoesNotStandHolds) {
  troubles[1].refuses = Error(Errc::not_standing, "frame: standstill not confirmed");
  expect_held({"not_standing"});
  EXPECT_EQ(runs(), 0);
  EXPECT_EQ(state(1), "waiting");
}

TEST_F(CausesAtTheStart, AnotherMeterThanInTheRunBeforeHolds) {
  troubles[2].at_start = [](Instruments& rig) {
    rig.door()->power_meter("LCR-6100,REV E8.13,OTHER0007,Good Will Instrument Co., Ltd.");
  };
  queue_up({"paper-1", "paper-1"}, {{"unattended", true}, {"on_failure", "skip"}});
  ok("queue.start");
  ASSERT_TRUE(until_gate("specimen"));
  ok("queue.answer", {{"text", "paper-1"}});
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "other_instrument");
  EXPECT_EQ(runs(), 1);
  EXPECT_EQ(state(2), "waiting");
  // A person confirms that the right one is there now.
  troubles[3].at_start = troubles[2].at_start;
  ok("queue.start");
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "empty");
  EXPECT_EQ(runs(), 2);
}

TEST_F(CausesAtTheStart, ASpecimenThatAPersonLeavesLoadedHolds) {
  queue_up({"paper-1", "paper-1"}, {{"unattended", true}, {"on_failure", "skip"}});
  ok("queue.start");
  ASSERT_TRUE(until_gate("specimen"));
  ok("queue.answer", {{"text", "paper-1"}});
  ASSERT_TRUE(until([this](const json&) {
    const json run = ok("status")["run"];
    return run.is_object() && run["step"] == "hold";
  }));
  ok("run.freeze");
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "left_loaded");
  EXPECT_EQ(runs(), 1);
}

}  // namespace
}  // namespace lcrig
