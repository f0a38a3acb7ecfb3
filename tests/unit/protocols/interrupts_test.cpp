// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/interrupts.hpp"

#include <gmock/gmock.h>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using Taken = InterruptQueue::Taken;

class Interrupts : public RunFixture {
 protected:
  InterruptQueue& queue() { return parts().interrupts; }
  static InterruptRequest request(Interrupt kind) { return InterruptRequest(kind, "test"); }
};

TEST_F(Interrupts, AreTakenInTheOrderInWhichTheyCame) {
  queue().ask(request(Interrupt::pause));
  queue().ask(request(Interrupt::abort));
  EXPECT_EQ(queue().take().kind, Interrupt::pause);
  EXPECT_EQ(queue().take().kind, Interrupt::abort);
  EXPECT_TRUE(queue().empty());
  EXPECT_THAT(sink.kinds(), ElementsAre("pause", "abort"));
}

// Nothing moves then, so the answer must not be that `finally` unloads.
TEST_F(Interrupts, AfterAFreezeNoStopIsAnsweredWithFinally) {
  queue().ask(request(Interrupt::freeze));
  queue().begin_finish(queue().take());
  EXPECT_TRUE(queue().frozen());
  EXPECT_EQ(queue().ask(request(Interrupt::abort)), Taken::acts);
  EXPECT_EQ(queue().ask(request(Interrupt::pause)), Taken::acts);
  EXPECT_TRUE(queue().empty());
}

TEST_F(Interrupts, OfOneKindWaitOnce) {
  for (int i = 0; i < 1000; ++i) queue().ask(request(Interrupt::pause));
  queue().take();
  EXPECT_TRUE(queue().empty());
}

TEST_F(Interrupts, AStopThatIsPendingHidesAllOthersButAFreeze) {
  queue().ask(request(Interrupt::abort));
  queue().ask(request(Interrupt::fault));
  queue().ask(request(Interrupt::freeze));
  EXPECT_THAT(sink.kinds(), ElementsAre("abort", "freeze"));
  EXPECT_TRUE(queue().stop_pending());
}

TEST_F(Interrupts, AStopIsTakenBeforeAPause) {
  queue().ask(request(Interrupt::pause));
  queue().ask(request(Interrupt::freeze));
  EXPECT_EQ(queue().take_stop().kind, Interrupt::freeze);
  EXPECT_EQ(queue().take().kind, Interrupt::pause);
}

// A run that ends where somebody asked still fails if a limit trips at that instant.
TEST_F(Interrupts, OfTheLastInstantCountMoreThanAPlannedStop) {
  queue().ask(request(Interrupt::limit));
  EXPECT_EQ(queue().begin_finish(request(Interrupt::stop_after))->kind, Interrupt::limit);
}

TEST_F(Interrupts, EndAWaitAtOnceAndStayInTheQueue) {
  bool ended = false;
  start(queue().wait(), ended);
  clock.run_for(io, 50ms);
  EXPECT_FALSE(ended);
  queue().push(request(Interrupt::loss));
  clock.run_for(io, 1ns);
  EXPECT_TRUE(ended);
  EXPECT_EQ(queue().next().kind, Interrupt::loss);
}

TEST_F(Interrupts, WhoeverWaitsLooksAroundTenTimesASecond) {
  bool ended = false;
  start(queue().wait(), ended);
  clock.run_for(io, 1050ms);
  EXPECT_EQ(looks, 10);
  EXPECT_EQ(queue().ticks(), 11U);
  EXPECT_EQ(queue().own_lag(clock.now()), Duration::zero());
}

TEST_F(Interrupts, APauseDoesNotStopAPreparation) {
  bool ended = false;
  start(queue().wait_for_stop(), ended);
  queue().ask(request(Interrupt::pause));
  clock.run_for(io, 1s);
  EXPECT_FALSE(ended);
  queue().ask(request(Interrupt::abort));
  clock.run_for(io, 1ms);
  EXPECT_TRUE(ended) << "at once";
}

TEST_F(Interrupts, OnlyWhatIsDangerousEndsFinally) {
  queue().begin_finish(std::nullopt);
  EXPECT_EQ(queue().ask(request(Interrupt::abort)), Taken::finally_goes_on);
  EXPECT_EQ(queue().ask(request(Interrupt::pause)), Taken::finally_goes_on);
  EXPECT_TRUE(queue().empty());
  EXPECT_EQ(queue().ask(request(Interrupt::limit)), Taken::acts);
  EXPECT_FALSE(queue().empty());
}

TEST_F(Interrupts, AStopOfTheLastInstantIsOne) {
  queue().ask(request(Interrupt::abort));
  const auto stop = queue().begin_finish(std::nullopt);
  ASSERT_TRUE(stop);
  EXPECT_EQ(stop->kind, Interrupt::abort);
  EXPECT_FALSE(queue().stop_pending());
}

TEST_F(Interrupts, AFreezeOfTheLastInstantIsMeant) {
  queue().ask(request(Interrupt::freeze));
  const auto stop = queue().begin_finish(request(Interrupt::abort));
  EXPECT_EQ(stop->kind, Interrupt::freeze);
}

TEST_F(Interrupts, ALossOfTheLastInstantStopsNothing) {
  queue().push(request(Interrupt::loss));
  EXPECT_FALSE(queue().begin_finish(std::nullopt));
  EXPECT_TRUE(queue().empty());
}

TEST_F(Interrupts, NothingCanBeAskedOfARunThatIsOver) {
  queue().close();
  EXPECT_EQ(queue().ask(request(Interrupt::freeze)), Taken::over);
  EXPECT_TRUE(sink.events.empty());
}

TEST_F(Interrupts, APauseIsResumedOnce) {
  EXPECT_TRUE(queue().resume());
  EXPECT_FALSE(queue().resume()) << "nobody has taken the first one yet";
  bool ended = false;
  start(queue().resumed(), ended);
  clock.run_for(io, 1ns);
  EXPECT_TRUE(ended);
}

TEST(InterruptOfAnError, IsALimitAnAbortOrAFault) {
  EXPECT_EQ(request_for(Error(Errc::limit_tripped, "")).kind, Interrupt::limit);
  EXPECT_EQ(request_for(Error(Errc::aborted, "")).kind, Interrupt::abort);
  EXPECT_EQ(request_for(Error(Errc::no_reply, "")).kind, Interrupt::fault);
}

}  // namespace
}  // namespace lcrig
