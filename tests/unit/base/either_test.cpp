// SPDX-License-Identifier: Apache-2.0
#include "base/either.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "base/clock.hpp"
#include "tests/support/run_task.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

Task<std::unique_ptr<std::string>> word_after(Clock& clock, Duration d, std::string word) {
  co_await clock.wait_for(d);
  co_return std::make_unique<std::string>(std::move(word));
}

Task<> tick(Clock& clock, Duration d, int& ticks) {
  co_await clock.wait_for(d);
  ++ticks;
}

Task<> throw_after(Clock& clock, Duration d) {
  co_await clock.wait_for(d);
  throw std::runtime_error("on purpose");
}

TEST(Either, GivesTheResultOfTheFirst) {
  VirtualClock clock;
  asio::io_context io;
  auto r =
      run_task(io, clock, either(word_after(clock, 1s, "first"), word_after(clock, 1h, "second")));
  ASSERT_EQ(r.index(), 0U);
  EXPECT_EQ(*std::get<0>(r), "first");
  EXPECT_EQ(clock.now().time_since_epoch(), 1s);
  EXPECT_EQ(clock.pending(), 0U);
}

TEST(Either, GivesTheResultOfTheSecond) {
  VirtualClock clock;
  asio::io_context io;
  int ticks = 0;
  auto r = run_task(io, clock, either(tick(clock, 1h, ticks), word_after(clock, 2s, "second")));
  ASSERT_EQ(r.index(), 1U);
  EXPECT_EQ(*std::get<1>(r), "second");
  EXPECT_EQ(clock.now().time_since_epoch(), 2s);
}

// The clock's wait ends early when it is cancelled. The loser then runs to its end.
TEST(Either, WaitsForTheEndOfTheLoser) {
  VirtualClock clock;
  asio::io_context io;
  int ticks = 0;
  auto r = run_task(io, clock, either(tick(clock, 1h, ticks), clock.wait_for(1s)));
  EXPECT_EQ(r.index(), 1U);
  EXPECT_EQ(ticks, 1);
}

TEST(Either, TheOneThatThrowsFirstDoesNotWin) {
  VirtualClock clock;
  asio::io_context io;
  auto r = run_task(io, clock, either(throw_after(clock, 1s), word_after(clock, 5s, "late")));
  ASSERT_EQ(r.index(), 1U);
  EXPECT_EQ(*std::get<1>(r), "late");
}

Task<bool> two_ticks(Clock& clock, int& ticks) {
  co_await both(tick(clock, 1s, ticks), tick(clock, 1min, ticks));
  co_return true;
}

TEST(Both, EndsWithTheLaterOne) {
  VirtualClock clock;
  asio::io_context io;
  int ticks = 0;
  EXPECT_TRUE(run_task(io, clock, two_ticks(clock, ticks)));
  EXPECT_EQ(ticks, 2);
  EXPECT_EQ(clock.now().time_since_epoch(), 1min);
}

}  // namespace
}  // namespace lcrig
