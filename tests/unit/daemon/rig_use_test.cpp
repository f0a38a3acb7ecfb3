// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/rig_use.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/spawn.hpp"
#include "tests/support/run_task.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

class Use : public testing::Test {
 protected:
  Result<> claim(RigUse::State state) { return run_task(io_, clock_, use_.claim(state)); }
  VirtualClock clock_;
  asio::io_context io_{1};
  RigUse use_{clock_};
};

TEST_F(Use, IsOneAtATime) {
  ASSERT_TRUE(claim(RigUse::State::asking));
  const MonoTime begin = clock_.now();
  const auto second = claim(RigUse::State::starting);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::busy);
  EXPECT_THAT(second.error().what, HasSubstr("try again"));
  EXPECT_EQ(clock_.now() - begin, 30s) << "it might have become free";
  EXPECT_EQ(use_.state(), RigUse::State::asking);
}

Task<> give_back_soon(Clock& clock, RigUse& use) {
  co_await clock.wait_for(2s);
  use.give_back();
}

TEST_F(Use, GoesToTheNextAsSoonAsItIsGivenBack) {
  ASSERT_TRUE(claim(RigUse::State::asking));
  spawn(io_.get_executor(), give_back_soon(clock_, use_));
  const MonoTime begin = clock_.now();
  EXPECT_TRUE(claim(RigUse::State::starting));
  EXPECT_EQ(clock_.now() - begin, 2s);
  EXPECT_TRUE(use_.is_for_run());
}

TEST_F(Use, OfADaemonThatEndsIsRefusedAtOnce) {
  ASSERT_TRUE(claim(RigUse::State::asking));
  use_.end();
  const MonoTime begin = clock_.now();
  const auto refused = claim(RigUse::State::starting);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, HasSubstr("shutting down"));
  EXPECT_EQ(clock_.now(), begin);
  EXPECT_EQ(use_.may_go_on().error().code, Errc::aborted);
}

TEST_F(Use, AStopConcernsTheStartThatIsUnderWayAndNoLaterOne) {
  ASSERT_TRUE(claim(RigUse::State::starting));
  EXPECT_TRUE(use_.may_go_on());
  use_.stop_start(InterruptRequest(Interrupt::abort, "by ada"));
  EXPECT_THAT(use_.may_go_on().error().what, HasSubstr("by ada"));
  use_.give_back();
  ASSERT_TRUE(claim(RigUse::State::starting));
  EXPECT_TRUE(use_.may_go_on());
}

Task<> wait_for_idle(RigUse& use, std::vector<std::string>& told) {
  const auto is_idle = [&use] { return use.is_idle(); };
  co_await use.wait(is_idle);
  told.push_back("who waited");
}

// Work that waits for an idle rig (a new config) is done before anybody else may use the rig.
TEST_F(Use, TellsItsOwnerBeforeThoseWhoWait) {
  std::vector<std::string> told;
  RigUse::Listener listener;
  listener.idle = [&told] { told.push_back("idle"); };
  listener.entered = [&told] { told.push_back("entered"); };
  use_.set_listener(std::move(listener));
  ASSERT_TRUE(claim(RigUse::State::asking));
  EXPECT_THAT(told, ElementsAre("entered"));
  told.clear();
  spawn(io_.get_executor(), wait_for_idle(use_, told));
  io_.poll();
  use_.give_back();
  clock_.run_for(io_, 1s);
  EXPECT_THAT(told, ElementsAre("idle", "entered", "who waited"));
}

TEST_F(Use, KeepsTheLastOutcomeAndHasNoRunThen) {
  ASSERT_TRUE(claim(RigUse::State::starting));
  EXPECT_FALSE(use_.last_run());
  RunOutcome ended;
  ended.run = 7;
  use_.end_run(ended);
  EXPECT_TRUE(use_.is_idle());
  EXPECT_EQ(use_.last_run()->run, 7);
  EXPECT_EQ(use_.live_run(), nullptr);
  EXPECT_EQ(use_.running().error().code, Errc::invalid_request);
}

}  // namespace
}  // namespace lcrig
