// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/event_log.hpp"

#include <gtest/gtest.h>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

class Log : public RunFixture {
 protected:
  const RunEvent& last() const { return sink.events.back(); }

  EventLog log{clock, sink};
};

TEST_F(Log, WritesWordsAtTheTimeOfTheClock) {
  clock.run_for(io, 3s);
  log.event(EventKind::refused, "no");
  ASSERT_EQ(sink.events.size(), 1U);
  EXPECT_EQ(last().t, MonoTime(3s));
  EXPECT_EQ(last().kind, EventKind::refused);
  EXPECT_EQ(last().detail, "no");
}

TEST_F(Log, WritesAPayloadAsItsJsonAndKeepsIt) {
  log.event(ClockStepEvent{1.5});
  EXPECT_EQ(last().kind, EventKind::clock_step);
  EXPECT_EQ(last().detail, to_json(ClockStepEvent{1.5}));
  ASSERT_TRUE(last().as<ClockStepEvent>());
  EXPECT_EQ(last().as<ClockStepEvent>()->seconds, 1.5);
}

TEST_F(Log, NamesTheStepFromItsBeginToItsEnd) {
  log.event(EventKind::rest, "");
  EXPECT_EQ(last().step_id, "");
  log.begin_step(step(1));
  EXPECT_EQ(log.step_id(), "s");
  log.event(EventKind::rest, "");
  EXPECT_EQ(last().step_id, "s");
  log.event(StepEndEvent());
  EXPECT_EQ(last().step_id, "s") << "the end of a step belongs to it";
  log.end_step();
  log.event(EventKind::rest, "");
  EXPECT_EQ(last().step_id, "");
}

}  // namespace
}  // namespace lcrig
