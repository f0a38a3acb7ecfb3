// SPDX-License-Identifier: Apache-2.0
#include "daemon/aside.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <future>
#include <stdexcept>

#include "tests/support/run_task.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

// A job that ends only after the loop did something else: on the loop's own thread it never would.
TEST(Aside, TheLoopServesOthersWhileAJobWorks) {
  asio::io_context io;
  RealClock clock;
  std::promise<int> served;
  auto wanted = served.get_future();
  const auto job = [&] {
    asio::post(io, [&] { served.set_value(42); });
    return wanted.wait_for(30s) == std::future_status::ready ? wanted.get() : 0;
  };
  EXPECT_EQ(run_task(io, run_aside(io.get_executor(), clock, job)), 42);
}

Task<int> wait_and_count(VirtualClock& clock, int& late) {
  co_await clock.wait_for(1ms);
  co_return ++late;
}

TEST(Aside, VirtualTimeStandsStillMeanwhile) {
  asio::io_context io{1};
  VirtualClock clock;
  int late = 0;
  support::Outcome<int> timer, job_done;
  support::spawn(io, wait_and_count(clock, late), timer);
  // The loop has turns enough to let time go on.
  const auto job = [&io] {
    for (int turn = 0; turn < 20; ++turn) {
      std::promise<void> served;
      asio::post(io, [&served] { served.set_value(); });
      served.get_future().wait();
    }
    return 1;
  };
  support::spawn(io, run_aside(io.get_executor(), clock, job), job_done);
  EXPECT_TRUE(clock.run(io, [&] { return job_done.done; }));
  EXPECT_EQ(clock.now(), MonoTime());
  EXPECT_EQ(late, 0);
  EXPECT_TRUE(clock.run(io, [&] { return timer.done; }));
}

TEST(Aside, ABugOfTheJobIsABugOfWhoeverAsked) {
  asio::io_context io;
  RealClock clock;
  const auto job = []() -> int { throw std::logic_error("broken"); };
  EXPECT_THROW(run_task(io, run_aside(io.get_executor(), clock, job)), std::logic_error);
}

}  // namespace
}  // namespace lcrig
