// SPDX-License-Identifier: Apache-2.0
#include "base/aside.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>

#include "base/either.hpp"
#include "tests/support/run_task.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

// The job ends only after the loop did something else. On the loop's own thread it would never end.
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

// A cancelled caller waits for the job, which uses what belongs to the caller. The loop goes on.
TEST(Aside, ACallerThatIsCancelledLeavesNothingBehind) {
  asio::io_context io;
  RealClock clock;
  std::promise<void> released;
  auto release = released.get_future().share();
  int turns = 0;
  const auto job = [release, text = std::string(100, 'x')] {
    release.wait_for(30s);
    return text.size();
  };
  const auto count_and_release = [&]() -> Task<std::size_t> {
    for (; turns < 20; ++turns) co_await clock.wait_for(1ms);
    released.set_value();
    co_return 0;
  };
  const auto race = [&]() -> Task<std::size_t> {
    auto cancelled = run_aside(io.get_executor(), clock, job);
    auto first = clock.wait_for(1ms);
    auto r = co_await either(std::move(cancelled), std::move(first));
    co_return r.index();
  };
  support::Outcome<std::size_t> raced, counted;
  support::spawn(io, race(), raced);
  support::spawn(io, count_and_release(), counted);
  io.run();
  EXPECT_TRUE(raced.done);
  EXPECT_EQ(turns, 20) << "the loop stood still while the job worked";
}

// The result of an abandoned job is destroyed on the job's thread, as the loop may be gone.
TEST(Aside, AnAbandonedJobCleansUpBehindItself) {
  std::promise<void> released, destroyed;
  auto release = released.get_future().share();
  struct Tell {
    void operator()(std::promise<void>* p) const { p->set_value(); }
  };
  using Port = std::unique_ptr<std::promise<void>, Tell>;
  {
    asio::io_context io;
    RealClock clock;
    const auto job = [release, &destroyed] {
      release.wait();
      return Port(&destroyed);
    };
    const auto race = [&]() -> Task<std::size_t> {
      auto cancelled = run_abandonable(io.get_executor(), clock, job);
      auto first = clock.wait_for(1ms);
      auto r = co_await either(std::move(cancelled), std::move(first));
      co_return r.index();
    };
    EXPECT_EQ(run_task(io, race()), 1U);
  }
  auto gone = destroyed.get_future();
  EXPECT_EQ(gone.wait_for(0s), std::future_status::timeout);
  released.set_value();
  EXPECT_EQ(gone.wait_for(30s), std::future_status::ready);
}

TEST(Aside, AnAbandonableJobThatIsWaitedForReturnsItsResult) {
  asio::io_context io;
  RealClock clock;
  const auto job = [] { return std::make_unique<int>(7); };
  auto got = run_task(io, run_abandonable(io.get_executor(), clock, job));
  ASSERT_TRUE(got);
  EXPECT_EQ(**got, 7);
}

}  // namespace
}  // namespace lcrig
