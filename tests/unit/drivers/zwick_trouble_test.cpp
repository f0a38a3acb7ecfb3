// SPDX-License-Identifier: Apache-2.0
// Driver and simulated gateway when the other side is silent, refuses, or is not the expected one;
// over memory in virtual time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/frame_bench.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

TEST(ZwickLink, ALinkThatGoesSilentIsLostAfterOneSecondAndOnlyOnce) {
  FrameBench b;
  b.armed();
  const auto move = b.begin(b.frame->move_to(4.0_mm, 0.01_mm_s));
  b.pass(1s);
  b.sim->faults.silent = true;
  const MonoTime begin = b.clock.now();
  const auto r = b.await(*move);
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::disconnected);
  EXPECT_LE(b.clock.now() - begin, 1s);
  EXPECT_GT(b.clock.now() - begin, 700ms);
  EXPECT_EQ(b.listener.lost.size(), 1U);
  EXPECT_FALSE(b.run(b.frame->hold_travel()));
  EXPECT_FALSE(b.run(b.frame->stop()));
  EXPECT_EQ(b.listener.lost.size(), 1U);
  b.settle();
  EXPECT_FALSE(b.sim->is_moving() && !b.sim_ended);
}

TEST(ZwickSim, StopsAndDisarmsWhenTheHostIsSilent) {
  FrameBench b;
  b.armed();
  const auto move = b.begin(b.frame->move_to(4.0_mm, 0.1_mm_s));
  b.pass(1s);
  b.sim->faults.deaf = true;
  const auto r = b.await(*move);
  ASSERT_TRUE(r);
  EXPECT_EQ(r->reason, MotionEnd::fault);
  EXPECT_EQ(r->detail, "host silent");
  EXPECT_FALSE(b.sim->is_armed());
  b.pass(100ms);
  EXPECT_TRUE(b.listener.has_event("device_watchdog"));
  b.sim->faults.deaf = false;
  b.pass(1s);
  EXPECT_FALSE(b.run(b.frame->move_to(4.0_mm, 0.1_mm_s)));
}

TEST(ZwickSim, StopsWhenTheConnectionCloses) {
  FrameBench b;
  b.armed();
  const auto move = b.begin(b.frame->move_to(4.0_mm, 0.1_mm_s));
  b.pass(1s);
  b.frame->close();
  const auto r = b.await(*move);
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::disconnected);
  EXPECT_TRUE(b.listener.lost.empty()) << "closing on purpose is no loss";
  b.settle();
  EXPECT_TRUE(b.sim_ended);
  const double travel = b.scene.travel_m(b.clock.now() + 1s);
  EXPECT_NEAR(travel, 0.1e-3, 1e-5);
  EXPECT_EQ(b.clock.pending(), 0U);
}

TEST(ZwickLink, ARefusalNamesTheReasonAndTheDevice) {
  FrameBench b;
  b.armed();
  b.sim->faults.refuse_next = "not_ready";
  const auto r = b.run(b.frame->move_to(1.0_mm, 0.1_mm_s));
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::frame_fault);
  EXPECT_THAT(r.error().what, HasSubstr("sim:frame"));
  EXPECT_THAT(r.error().what, HasSubstr("not_ready"));
}

TEST(ZwickLink, AnUnansweredMotionIsStopped) {
  FrameBench b;
  b.armed();
  b.sim->faults.lose_answers = 1;
  const auto r = b.run(b.frame->move_to(4.0_mm, 0.1_mm_s));
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::no_reply);
  EXPECT_THAT(r.error().what, HasSubstr("MOVE travel_mm=4"));
  b.pass(100ms);
  EXPECT_FALSE(b.sim->is_moving());
}

TEST(ZwickLink, AnswersToOlderNumbersMatchNothing) {
  FrameBench b;
  b.armed();
  const auto move = b.begin(b.frame->move_to(4.0_mm, 0.1_mm_s));
  b.pass(100ms);
  b.sim->faults.say = "OK #1\nDONE #1 reason=target\nERR #2 code=busy\nDONE #99 reason=target\n";
  b.sim->poke();
  b.pass(1s);
  EXPECT_FALSE(move->done());
  EXPECT_EQ(b.run(b.frame->stop()).has_value(), true);
  EXPECT_EQ(b.await(*move)->reason, MotionEnd::stopped);
}

TEST(ZwickLink, ALostCompletionEndsWithStop) {
  FrameBench b;
  b.armed();
  b.sim->faults.lose_done = 1;
  const auto move = b.begin(b.frame->move_to(0.1_mm, 0.1_mm_s));
  b.pass(10s);
  EXPECT_FALSE(move->done());
  EXPECT_TRUE(b.run(b.frame->stop()));
}

TEST(ZwickLink, AStalledOrEndlessMotionEndsWithStop) {
  for (const bool stall : {false, true}) {
    FrameBench b;
    b.armed();
    b.sim->faults.never_complete = !stall;
    const auto move = b.begin(b.frame->move_to(0.1_mm, 0.1_mm_s));
    b.pass(500ms);
    if (stall) b.sim->stall();
    b.pass(10s);
    EXPECT_FALSE(move->done());
    EXPECT_TRUE(b.run(b.frame->stop()));
    EXPECT_EQ(b.await(*move)->reason, MotionEnd::stopped);
  }
}

TEST(ZwickLink, StopIsSentAgainWhenItsAnswerIsLost) {
  FrameBench b;
  b.armed();
  b.sim->faults.lose_stopped = 1;
  const MonoTime begin = b.clock.now();
  EXPECT_TRUE(b.run(b.frame->stop()));
  EXPECT_GE(b.clock.now() - begin, 1s);
  b.sim->faults.lose_stopped = 2;
  const auto r = b.run(b.frame->stop());
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::not_standing);
  EXPECT_TRUE(b.run(b.frame->stop()));
}

TEST(ZwickLink, GarbageAndUnknownMessagesAreReportedAndIgnored) {
  FrameBench b;
  b.armed();
  b.sim->faults.say = "\x01\x02\nNEWS a=1\nS seq=x\nOK\n";
  b.sim->poke();
  b.pass(3s);
  EXPECT_TRUE(b.listener.has_event("garbled"));
  EXPECT_TRUE(b.listener.lost.empty());
  EXPECT_TRUE(b.run(b.frame->resync()));
}

TEST(ZwickLink, AGatewayThatRestartsIsALostLink) {
  FrameBench b;
  b.armed();
  b.sim->faults.say = "HELLO proto=1 side=gateway\n";
  b.sim->poke();
  b.pass(100ms);
  ASSERT_EQ(b.listener.lost.size(), 1U);
  EXPECT_THAT(b.listener.lost[0].what, HasSubstr("restarted"));
}

TEST(ZwickLink, TwoMotionsAtOnceAreRefusedAndTheFirstGoesOn) {
  FrameBench b;
  b.armed();
  const auto move = b.begin(b.frame->move_to(1.0_mm, 0.1_mm_s));
  const auto second = b.run(b.frame->move_to(0.0_mm, 0.1_mm_s));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::busy);
  EXPECT_EQ(b.await(*move)->reason, MotionEnd::target);
}

TEST(ZwickLink, SilenceAtTheStartBecomesNoReply) {
  MuteBench b;
  const auto r = run_task(b.io, b.clock, b.frame->identify());
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::no_reply);
  EXPECT_EQ(b.clock.now().time_since_epoch(), 2s);
}

TEST(ZwickLink, AnotherInstrumentIsRecognisedAsSuch) {
  MuteBench b;
  ASSERT_TRUE(run_task(b.io, b.clock, b.far->write_all("GW Instek,LCR-6100\r\n", MonoTime() + 1s)));
  const auto r = run_task(b.io, b.clock, b.frame->identify());
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::garbled);
  EXPECT_THAT(r.error().what, HasSubstr("GW Instek"));
}

TEST(ZwickLink, AnotherProtocolVersionIsRefused) {
  MuteBench b;
  support::Outcome<Result<Identity>> out;
  support::spawn(b.io, b.frame->identify(), out);
  b.clock.run_for(b.io, 100ms);
  ASSERT_TRUE(run_task(b.io, b.clock, b.far->write_all("HELLO proto=2\n", b.clock.now() + 1s)));
  b.clock.run(b.io, [&] { return out.done; });
  const auto r = support::take(out);
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::refused);
  EXPECT_THAT(r.error().what, HasSubstr("frame-link/2"));
}

TEST(ZwickLink, IsDestroyedSafelyInTheMiddleOfASession) {
  auto b = std::make_unique<FrameBench>();
  b->armed();
  b->pass(1s);
  b->frame.reset();
  b->settle();
  EXPECT_TRUE(b->sim_ended);
  EXPECT_EQ(b->clock.pending(), 0U);
  auto unpolled = std::make_unique<FrameBench>();
  unpolled->armed();
  unpolled.reset();
}

}  // namespace
}  // namespace lcrig
