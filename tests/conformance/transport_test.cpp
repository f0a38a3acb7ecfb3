// SPDX-License-Identifier: Apache-2.0
// The promises of both ends of every wire, in virtual time. Another wire adds one line at the end.
#include <gtest/gtest.h>

#include <array>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <functional>
#include <string>

#include "drivers/fd_transport.hpp"
#include "drivers/memory_pipe.hpp"
#include "tests/support/run_task.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

struct WireKind {
  const char* name;
  MakeWire make;
};

class EveryWire : public testing::TestWithParam<WireKind> {
 protected:
  void SetUp() override {
    auto pair = GetParam().make(io.get_executor(), clock, "wire");
    ASSERT_TRUE(pair);
    near = std::move(pair->near);
    far = std::move(pair->far);
  }
  void TearDown() override {
    if (near) near->close();
    if (far) far->close();
    settle();
  }
  void settle() {
    for (io.restart(); io.poll() > 0; io.restart()) {
    }
  }
  Result<std::string> read(Transport& end, std::size_t at_most = 512, Duration within = 1s) {
    std::string buffer(at_most, '\0');
    const auto n = run_task(io, clock, end.read_some(buffer, clock.now() + within));
    if (!n) return fail(n.error());
    return buffer.substr(0, *n);
  }
  Result<> write(Transport& end, const std::string& bytes) {
    return run_task(io, clock, end.write_all(bytes, clock.now() + 1s));
  }
  // Begins a task, cancels it while it waits, and returns its outcome.
  template <class T>
  T cancelled(Task<T> task) {
    asio::cancellation_signal signal;
    support::Outcome<T> out;
    asio::co_spawn(io, std::move(task),
                   asio::bind_cancellation_slot(signal.slot(), [&](std::exception_ptr e, T value) {
                     out.error = e;
                     out.value = std::move(value);
                   }));
    settle();
    signal.emit(asio::cancellation_type::terminal);
    settle();
    return support::take(out);
  }

  VirtualClock clock;  // outlives io: waits that are destroyed with io deregister here
  asio::io_context io;
  std::unique_ptr<Transport> near, far;
};

TEST_P(EveryWire, CarriesBytesBothWaysInTheirOrder) {
  ASSERT_TRUE(write(*near, "one"));
  ASSERT_TRUE(write(*near, "two"));
  ASSERT_TRUE(write(*far, "three"));
  EXPECT_EQ(read(*far), "onetwo");
  EXPECT_EQ(read(*near), "three");
  EXPECT_EQ(clock.now(), MonoTime());
}

TEST_P(EveryWire, ASmallBufferTakesAPart) {
  ASSERT_TRUE(write(*near, "FETC?\n"));
  EXPECT_EQ(read(*far, 4), "FETC");
  EXPECT_EQ(read(*far, 4), "?\n");
}

TEST_P(EveryWire, ReadersWaitForBytes) {
  asio::co_spawn(
      io,
      [this]() -> Task<> {
        co_await clock.wait_for(300ms);
        auto written = co_await far->write_all("late", MonoTime::max());
        static_cast<void>(written);
      },
      asio::detached);
  EXPECT_EQ(read(*near), "late");
  EXPECT_EQ(clock.now().time_since_epoch(), 300ms);
  EXPECT_EQ(clock.pending(), 0U);
}

TEST_P(EveryWire, SilenceIsNoReplyAtTheDeadline) {
  const auto nothing = read(*near);
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().code, Errc::no_reply);
  EXPECT_EQ(clock.now().time_since_epoch(), 1s);
  EXPECT_EQ(clock.pending(), 0U);
}

TEST_P(EveryWire, ALookDoesNotWait) {
  const auto nothing = read(*near, 512, 0s);
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().code, Errc::no_reply);
  ASSERT_TRUE(write(*far, "there"));
  EXPECT_EQ(read(*near, 512, 0s), "there");
  EXPECT_EQ(clock.now(), MonoTime());
}

TEST_P(EveryWire, WhatWasSentBeforeAnEndClosedIsStillRead) {
  ASSERT_TRUE(write(*far, "last words"));
  far->close();
  EXPECT_EQ(read(*near, 4), "last");
  EXPECT_EQ(read(*near), " words");
  const auto over = read(*near);
  ASSERT_FALSE(over);
  EXPECT_EQ(over.error().code, Errc::disconnected);
  EXPECT_EQ(over.error().what, "wire: the port went away (read)");
}

TEST_P(EveryWire, NobodyWritesToAnEndThatClosed) {
  far.reset();
  const auto written = write(*near, "hello?");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, Errc::disconnected);
  EXPECT_EQ(written.error().what, "wire: the port went away (write)");
}

TEST_P(EveryWire, AnEndThatIsClosedStaysSo) {
  ASSERT_TRUE(write(*far, "unread"));
  near->close();
  near->close();
  const auto got = read(*near);
  ASSERT_FALSE(got);
  EXPECT_EQ(got.error().code, Errc::disconnected);
  const auto written = write(*near, "x");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, Errc::disconnected);
}

TEST_P(EveryWire, ClosingEitherEndEndsAWaitAtOnce) {
  for (const bool own : {true, false}) {
    SetUp();
    asio::post(io, [this, own] { own ? near->close() : far->close(); });
    const auto got = read(*near);
    ASSERT_FALSE(got);
    EXPECT_EQ(got.error().code, Errc::disconnected);
    EXPECT_EQ(clock.now(), MonoTime());
    EXPECT_EQ(clock.pending(), 0U);
  }
}

TEST_P(EveryWire, AWireThatNobodyReadsTakesNoMoreAtTheDeadline) {
  const auto written = write(*near, std::string(10'000'000, 'x'));
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, Errc::io);
  EXPECT_EQ(written.error().what, "wire: the other side takes no bytes");
  EXPECT_EQ(clock.now().time_since_epoch(), 1s);
}

TEST_P(EveryWire, AFullWireGoesOnWhenItIsRead) {
  const std::string sent(1'000'000, 'x');
  support::Outcome<Result<>> out;
  support::spawn(io, far->write_all(sent, clock.now() + 1s), out);
  settle();
  EXPECT_FALSE(out.done);
  std::size_t received = 0;
  while (received < sent.size()) {
    const auto got = read(*near, 8192);
    ASSERT_TRUE(got) << received << ": " << got.error().what;
    received += got->size();
  }
  settle();
  EXPECT_TRUE(support::take(out));
  EXPECT_EQ(clock.now(), MonoTime());
}

TEST_P(EveryWire, ClosingEndsAWriteThatWaits) {
  const std::string sent(10'000'000, 'x');
  support::Outcome<Result<>> out;
  support::spawn(io, near->write_all(sent, clock.now() + 1s), out);
  settle();
  far->close();
  settle();
  const auto written = support::take(out);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, Errc::disconnected);
  EXPECT_EQ(clock.pending(), 0U);
}

TEST_P(EveryWire, ACancelledWaitEndsAndLeavesTheWireAsItWas) {
  std::array<char, 16> buffer{};
  for (const MonoTime deadline : {clock.now() + 1s, MonoTime::max()}) {
    const auto got = cancelled(near->read_some(buffer, deadline));
    ASSERT_FALSE(got);
    EXPECT_EQ(got.error().code, Errc::disconnected);
  }
  const std::string much(10'000'000, 'x');
  const auto written = cancelled(near->write_all(much, clock.now() + 1s));
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, Errc::disconnected);
  EXPECT_EQ(clock.pending(), 0U);
  ASSERT_TRUE(write(*far, "still here"));
  EXPECT_EQ(read(*near), "still here");
}

TEST_P(EveryWire, AFloodKeepsNobodyFromRunning) {
  ASSERT_TRUE(write(*far, std::string(10'000, 'x')));
  int reads = 0, others = 0;
  std::function<void()> other = [&] {
    ++others;
    if (reads < 10'000) asio::post(io, other);
  };
  asio::post(io, other);
  asio::co_spawn(
      io,
      [&]() -> Task<> {
        char byte = 0;
        for (; reads < 10'000; ++reads) {
          auto n = co_await near->read_some(std::span<char>(&byte, 1), clock.now() + 1s);
          static_cast<void>(n);
        }
      },
      asio::detached);
  settle();
  EXPECT_EQ(reads, 10'000);
  EXPECT_GT(others, 100);
}

INSTANTIATE_TEST_SUITE_P(Wires, EveryWire,
                         testing::Values(WireKind{"socketpair", make_socketpair},
                                         WireKind{"memory", make_memory_pipe}),
                         [](const auto& param) { return std::string(param.param.name); });

}  // namespace
}  // namespace lcrig
