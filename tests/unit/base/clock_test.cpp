// SPDX-License-Identifier: Apache-2.0
#include "base/clock.hpp"

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/local/connect_pair.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "base/either.hpp"
#include "tests/support/run_task.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

Task<> note_at(Clock& clock, Duration d, std::vector<int>& order, int id) {
  co_await clock.wait_for(d);
  order.push_back(id);
}

TEST(VirtualClock, WakesInOrderOfDeadlines) {
  asio::io_context io;
  VirtualClock clock;
  std::vector<int> order;
  asio::co_spawn(io, note_at(clock, 2h, order, 2), asio::detached);
  asio::co_spawn(io, note_at(clock, 1s, order, 1), asio::detached);
  EXPECT_FALSE(clock.run(io, [] { return false; }));
  EXPECT_EQ(order, (std::vector<int>{1, 2}));
  EXPECT_EQ(clock.now().time_since_epoch(), 2h);
  EXPECT_EQ(clock.pending(), 0U);
}

Task<> race(Clock& clock, bool& short_won) {
  auto r = co_await either(clock.wait_for(1s), clock.wait_for(1h));
  short_won = r.index() == 0;
}

TEST(VirtualClock, TheLoserOfARaceLeavesNoWaiter) {
  asio::io_context io;
  VirtualClock clock;
  bool short_won = false;
  asio::co_spawn(io, race(clock, short_won), asio::detached);
  clock.run(io, [] { return false; });
  EXPECT_TRUE(short_won);
  EXPECT_EQ(clock.pending(), 0U);
  EXPECT_EQ(clock.now().time_since_epoch(), 1s);
}

TEST(VirtualClock, RunForStopsAtItsEnd) {
  asio::io_context io;
  VirtualClock clock;
  std::vector<int> order;
  asio::co_spawn(io, note_at(clock, 2s, order, 2), asio::detached);
  clock.run_for(io, 1s);
  EXPECT_EQ(clock.now().time_since_epoch(), 1s);
  EXPECT_TRUE(order.empty());
  clock.run_for(io, 1s);
  EXPECT_EQ(order, std::vector<int>{2});
}

TEST(VirtualClock, AWallClockStepLeavesMonotonicTimeAlone) {
  VirtualClock clock;
  const auto before = clock.unix_ns();
  clock.step_wall_clock(-1h);
  EXPECT_EQ(before - clock.unix_ns(), Duration(1h).count());
  EXPECT_EQ(clock.now().time_since_epoch(), 0s);
}

Task<> after_a_while(Clock& clock, std::function<void()> act) {
  co_await clock.wait_for(1ms);
  act();
}

// On either clock.
template <class Run>
void expect_wakeup_works(asio::io_context& io, Clock& clock, Run run) {
  Wakeup early;
  asio::co_spawn(io, after_a_while(clock, [&early] { early.notify(); }), asio::detached);
  EXPECT_FALSE(run(clock.wait_until(clock.now() + 1h, early))) << "a knock ends the wait";
  early.notify();
  EXPECT_FALSE(run(clock.wait_until(MonoTime::max(), early))) << "a knock is remembered";
  EXPECT_TRUE(run(clock.wait_until(clock.now() + 1ms, early))) << "and then forgotten";
  auto brief = std::make_unique<Wakeup>();
  asio::co_spawn(io, after_a_while(clock, [&brief] { brief.reset(); }), asio::detached);
  EXPECT_FALSE(run(clock.wait_until(MonoTime::max(), *brief))) << "nobody is left who could knock";
}

TEST(Wakeup, EndsAWaitInVirtualTime) {
  asio::io_context io;
  VirtualClock clock;
  expect_wakeup_works(io, clock, [&](Task<bool> t) { return run_task(io, clock, std::move(t)); });
  EXPECT_EQ(clock.now().time_since_epoch(), 3ms);
  EXPECT_EQ(clock.pending(), 0U);
}

TEST(Wakeup, EndsAWaitInRealTime) {
  asio::io_context io;
  RealClock clock;
  expect_wakeup_works(io, clock, [&](Task<bool> t) { return run_task(io, std::move(t)); });
}

TEST(Wakeup, AWaitThatIsDestroyedIsForgotten) {
  VirtualClock clock;
  Wakeup early;
  {
    asio::io_context io;
    asio::co_spawn(io, clock.wait_until(clock.now() + 1h, early), asio::detached);
    io.poll();
    EXPECT_EQ(clock.pending(), 1U);
  }
  EXPECT_EQ(clock.pending(), 0U);
  early.notify();
}

TEST(RealClock, WaitsAtLeastUntilTheDeadline) {
  asio::io_context io;
  RealClock clock;
  const MonoTime begin = clock.now();
  EXPECT_TRUE(run_task(io, clock.wait_for(5ms)));
  EXPECT_GE(clock.now() - begin, 5ms);
}

using Socket = asio::local::stream_protocol::socket;

Task<> take_bytes(Socket& from, std::size_t n, std::string& taken) {
  while (taken.size() < n) {
    char byte = 0;
    co_await from.async_read_some(asio::buffer(&byte, 1), asio::use_awaitable);
    taken += byte;
  }
}

// The program gets no processor until the wait is 100 ms overdue. The bytes arrive in the meantime.
Task<std::size_t> taken_when_the_time_came(Clock& clock, Socket& far, const std::string& taken) {
  const auto executor = co_await asio::this_coro::executor;
  asio::post(executor, [&far, &clock, back = clock.now() + 105ms] {
    asio::write(far, asio::buffer("twenty bytes arrive..", 20));
    while (clock.now() < back) std::this_thread::yield();
  });
  co_await clock.wait_for(5ms);
  co_return taken.size();
}

TEST(RealClock, AWaitThatComesBackLateLetsArrivalsGoFirst) {
  asio::io_context io;
  RealClock clock;
  Socket near(io), far(io);
  asio::local::connect_pair(near, far);
  std::string taken;
  asio::co_spawn(io, take_bytes(near, 20, taken), asio::detached);
  EXPECT_EQ(run_task(io, taken_when_the_time_came(clock, far, taken)), 20U);
}

}  // namespace
}  // namespace lcrig
