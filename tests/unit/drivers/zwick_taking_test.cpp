// SPDX-License-Identifier: Apache-2.0
// How command of a frame is taken, what its zero is called, and what it reports about itself.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/frame_bench.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

TEST(ZwickTaking, AGatewayThatAnswersNoHelloHasGotAStop) {
  MuteBench b;
  EXPECT_FALSE(run_task(b.io, b.clock, b.frame->identify()));
  const std::string heard = b.heard();
  EXPECT_TRUE(heard.starts_with("\nSTOP\n\nHELLO ")) << heard;
}

TEST(ZwickTaking, AnObserverSaysNeitherStopNorHello) {
  MuteBench b;
  EXPECT_FALSE(run_task(b.io, b.clock, b.frame->observe(10)));
  const std::string heard = b.heard();
  EXPECT_THAT(heard, HasSubstr("OBSERVE "));
  EXPECT_THAT(heard, Not(HasSubstr("STOP")));
  EXPECT_THAT(heard, Not(HasSubstr("HELLO")));
}

// The number in it belongs to an earlier session, or to a STOP that came before HELLO.
TEST(ZwickTaking, AnEarlierStoppedConfirmsNoLaterStop) {
  FrameBench b;
  ASSERT_TRUE(b.run(b.frame->observe(50)));
  b.armed();
  b.sim->faults.say = "STOPPED stops=1\nSTOPPED stops=7\n";
  b.sim->poke();
  b.pass(100ms);
  b.sim->faults.lose_stopped = 2;
  const auto r = b.run(b.frame->stop());
  ASSERT_FALSE(r) << "nobody confirmed this one";
  EXPECT_EQ(r.error().code, Errc::not_standing);
}

// Twice, out of order, for a STOP that was not sent, for none, for a part of one.
TEST(ZwickTaking, OnlyTheCountOfAStopThatWasSentConfirmsIt) {
  for (const char* said : {"STOPPED stops=7\n", "STOPPED\n", "STOPPED stops=-1\n",
                           "STOPPED stops=x\n", "STOPPED stops=0\nSTOPPED stops=0\n"}) {
    SCOPED_TRACE(said);
    FrameBench b;
    b.armed();
    ASSERT_TRUE(b.run(b.frame->stop()));
    const auto move = b.begin(b.frame->move_to(0.9_mm, 0.01_mm_s));
    b.pass(500ms);
    b.sim->faults.lies.stop_ignored = true;
    b.sim->poke();
    const auto stop = b.begin(b.frame->stop());
    b.pass(100ms);
    b.sim->faults.say = std::string("STOPPED stops=1\n") + said + "STOPPED stops=1\n";
    b.sim->poke();
    b.pass(100ms);
    EXPECT_FALSE(stop->done()) << "it moves, and another STOP was confirmed";
    b.sim->faults.lies.stop_ignored = false;
    b.sim->poke();
    EXPECT_TRUE(b.await(*stop)) << "the repeated STOP is obeyed and confirmed";
    EXPECT_EQ(b.await(*move)->reason, MotionEnd::stopped);
  }
}

TEST(ZwickTaking, AMachineThatMovesIsStoppedByTheStopAlready) {
  FrameBench b;
  ASSERT_TRUE(b.run(b.frame->observe(50)));
  b.scene.move_to(b.clock.now(), 0.9e-3, 1e-5);
  ASSERT_TRUE(b.run(b.frame->identify()));
  EXPECT_TRUE(b.run(b.frame->stop()));
}

TEST(ZwickOrigin, IsKnownFromHelloZeroAndEvent) {
  FrameBench b;
  EXPECT_FALSE(b.frame->origin());
  ASSERT_TRUE(b.run(b.frame->observe(0)));
  EXPECT_EQ(b.frame->origin(), "1");
  b.armed();
  EXPECT_EQ(b.frame->origin(), "1");
  ASSERT_TRUE(b.run(b.frame->zero(true, false)));
  EXPECT_EQ(b.frame->origin(), "2");
  b.sim->faults.say = "EVENT kind=origin origin=\"at the \xff panel\" text=tared\n";
  b.sim->poke();
  b.pass(100ms);
  EXPECT_EQ(b.frame->origin(), "at the \\xff panel") << "what is stored is text";
}

TEST(ZwickOrigin, IsNotKnownOfAGatewayOfRevisionOne) {
  ZwickSimSettings old;
  old.revision = 1;
  FrameBench b(old);
  b.armed();
  ASSERT_TRUE(b.run(b.frame->zero(true, false)));
  EXPECT_FALSE(b.frame->origin());
}

TEST(ZwickFault, IsReportedAlsoOfAMotionThatNobodyWaitsForAnyMore) {
  FrameBench b;
  b.armed();
  b.sim->faults.say = "DONE #1 reason=fault text=\"E-stop\"\n";
  b.sim->poke();
  b.pass(100ms);
  ASSERT_TRUE(b.listener.has_event("motion_fault"));
  for (const char* kind : {"motion_fault", "device_estop", "device_drive_off", "device_shield",
                           "device_drive_fault"}) {
    EXPECT_TRUE(frame_fault_words(EventName(kind).kind())) << kind;
  }
  for (const char* kind : {"device_watchdog", "device_origin", "device_shield_closed", "estop"}) {
    EXPECT_FALSE(frame_fault_words(EventName(kind).kind())) << kind;
  }
}

TEST(ZwickFault, ASilentHostIsNone) {
  FrameBench b;
  b.armed();
  b.sim->faults.say =
      "DONE #1 reason=fault text=\"host silent\"\nDONE #1 reason=novel text=\"\"\n"
      "DONE #99 reason=fault text=\"of another session\"\n";
  b.sim->poke();
  b.pass(100ms);
  EXPECT_FALSE(b.listener.has_event("motion_fault"));
}

TEST(ZwickFault, ACommandThatAStopOvertookIsNone) {
  ZwickSimSettings slow;
  slow.answer_delay_s = 0.5;
  FrameBench b(slow);
  b.armed();
  b.sim->faults.refuse_next = "not_ready";
  const auto move = b.begin(b.frame->move_to(1.0_mm, 0.1_mm_s));
  const auto stop = b.begin(b.frame->stop());
  const auto r = b.await(*move);
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::refused);
  EXPECT_TRUE(b.await(*stop));
}

}  // namespace
}  // namespace lcrig
