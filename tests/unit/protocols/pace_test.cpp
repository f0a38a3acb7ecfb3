// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/pace.hpp"
#include "base/clock.hpp"

#include <gtest/gtest.h>

namespace lcrig {
namespace {

class FreeClock final : public Clock {
 public:
  MonoTime now() const override { return at; }
  std::int64_t unix_ns() const override { return 0; }
  MonoTime at{std::chrono::seconds(1000)};

 private:
  Task<bool> wait(MonoTime, Wakeup*) override { co_return false; }
};

class PaceOfARun : public ::testing::Test {
 protected:
  RunProgress after(int seconds) {
    clock.at += std::chrono::seconds(seconds);
    RunProgress out;
    pace.write_to(out);
    return out;
  }

  FreeClock clock;
  PlannedTimes planned{100, {{"search", 60}, {"load", 30}, {"clear", 10}}, 10};
  Pace pace{clock, planned};
};

TEST_F(PaceOfARun, MovesWithinAStep) {
  pace.begin_run();
  pace.begin_step("search");
  EXPECT_DOUBLE_EQ(after(0).left_s, 100);
  EXPECT_DOUBLE_EQ(after(15).left_s, 85);
  EXPECT_DOUBLE_EQ(after(15).elapsed_s, 30);
}

TEST_F(PaceOfARun, AStepCountsAsPlannedHoweverLongItTakes) {
  pace.begin_run();
  pace.begin_step("search");
  EXPECT_FALSE(after(60).overdue);
  EXPECT_DOUBLE_EQ(after(440).left_s, 40);  // late: nothing of what follows is gone
  EXPECT_TRUE(after(0).overdue) << "what stands still says so";
  pace.begin_step("load");
  EXPECT_DOUBLE_EQ(after(1).left_s, 39);
  pace.begin_step("clear");  // early
  EXPECT_DOUBLE_EQ(after(10).left_s, 0);
}

TEST_F(PaceOfARun, AStopLeavesFinallyToDo) {
  pace.begin_run();
  pace.begin_step("search");
  pace.begin_finally();
  pace.begin_step("clear");
  EXPECT_DOUBLE_EQ(after(4).left_s, 6);
}

TEST_F(PaceOfARun, NothingIsLeftOfAnEndedRun) {
  pace.begin_run();
  pace.begin_step("clear");
  RunProgress ended = after(20);
  EXPECT_TRUE(ended.overdue);
  ended.state = RunState::ended;
  pace.write_to(ended);
  EXPECT_FALSE(ended.overdue);
  EXPECT_EQ(ended.left_s, 0);
}

TEST_F(PaceOfARun, AContinuedRunHasDoneStepsBehindIt) {
  pace.begin_run();
  pace.pass_over("search");
  pace.begin_step("load");
  EXPECT_DOUBLE_EQ(after(0).left_s, 40);
}

}  // namespace
}  // namespace lcrig
