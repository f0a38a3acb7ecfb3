// SPDX-License-Identifier: Apache-2.0
#include "base/condition.hpp"

#include <gmock/gmock.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

class ConditionTest : public testing::Test {
 protected:
  void wait(MonoTime deadline) { asio::co_spawn(io_, wait_for_it(deadline), asio::detached); }
  Task<> wait_for_it(MonoTime deadline) {
    const auto is_true = [this] { return value_ >= 2; };
    const bool held = co_await condition_->wait(is_true, deadline);
    ended_.emplace_back(clock_.now().time_since_epoch() / 1ms, held);
  }
  void after(Duration d, int value) { asio::co_spawn(io_, set(d, value), asio::detached); }
  Task<> set(Duration d, int value) {
    co_await clock_.wait_for(d);
    value_ = value;
    condition_->notify_all();
  }

  VirtualClock clock_;
  asio::io_context io_{1};
  std::optional<Condition> condition_{clock_};
  int value_ = 0;
  std::vector<std::pair<std::int64_t, bool>> ended_;  // when, ms
};

TEST_F(ConditionTest, EveryWaiterReturnsInTheInstantInWhichItHolds) {
  wait(MonoTime::max());
  wait(MonoTime(1h));
  after(10ms, 1);  // changes something, but not enough
  after(25ms, 2);
  clock_.run(io_, [] { return false; });
  EXPECT_THAT(ended_, ElementsAre(std::pair(25, true), std::pair(25, true)));
}

TEST_F(ConditionTest, WhatHoldsAlreadyIsNotWaitedFor) {
  value_ = 2;
  wait(MonoTime());
  clock_.run(io_, [] { return false; });
  EXPECT_THAT(ended_, ElementsAre(std::pair(0, true)));
}

TEST_F(ConditionTest, TheDeadlineEndsAWaitThatIsKnockedInVain) {
  wait(MonoTime(20ms));
  after(10ms, 1);
  clock_.run(io_, [] { return false; });
  EXPECT_THAT(ended_, ElementsAre(std::pair(20, false)));
}

TEST_F(ConditionTest, AWaitOutlivesTheConditionUntilItsDeadline) {
  wait(MonoTime(20ms));
  io_.poll();
  condition_.reset();
  value_ = 2;
  clock_.run(io_, [] { return false; });
  EXPECT_THAT(ended_, ElementsAre(std::pair(20, true)));
}

}  // namespace
}  // namespace lcrig
