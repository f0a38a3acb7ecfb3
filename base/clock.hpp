// SPDX-License-Identifier: Apache-2.0
// The clocks that everything waits on: real time in the daemon, virtual time in rehearsals and
// tests. Other production code never names steady_clock, sleep_for or steady_timer, so that all of
// it can run in virtual time. Code that awaits nothing includes base/time.hpp.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <map>

#include "base/task.hpp"
#include "base/time.hpp"

namespace lcrig {

class RealClock final : public Clock {
 public:
  MonoTime now() const override;
  std::int64_t unix_ns() const override;

 private:
  Task<bool> wait(MonoTime t, Wakeup* early) override;
};

// Deterministic time for rehearsals and tests. It stands still while anything can run, then jumps
// to the earliest deadline. Used from one thread. Works with in-memory pipes and with socketpairs,
// but not with ptys: the kernel delivers pty bytes later (docs/decisions/0002).
class VirtualClock final : public Clock {
 public:
  explicit VirtualClock(std::int64_t unix_start_ns = 1'767'225'600'000'000'000);  // 2026-01-01

  MonoTime now() const override { return now_; }
  std::int64_t unix_ns() const override;

  // Steps the wall clock without touching monotonic time (an NTP step).
  void step_wall_clock(Duration d) { unix_offset_ns_ += d.count(); }
  std::size_t pending() const { return waiters_.size(); }
  bool advance_to_next();  // false when nobody waits

  // Time does not advance while a Hold exists, e.g. while another thread works on a commit.
  class Hold {
   public:
    explicit Hold(VirtualClock& clock) : clock_(&clock) { ++clock_->holds_; }
    ~Hold() { --clock_->holds_; }
    Hold(const Hold&) = delete;
    Hold& operator=(const Hold&) = delete;

   private:
    VirtualClock* clock_;
  };

  // Pumps `io` (poll until idle, then jump to the earliest deadline) until `done` or until nothing
  // is left to run. True when `done`.
  bool run(asio::io_context& io, const std::function<bool()>& done);
  void run_for(asio::io_context& io, Duration d);

 private:
  struct Waiter;
  Task<bool> wait(MonoTime t, Wakeup* early) override;
  bool pump(asio::io_context& io, const std::function<bool()>& done, MonoTime end);

  MonoTime now_{};
  std::int64_t unix_offset_ns_;
  int holds_ = 0;
  std::multimap<MonoTime, Waiter*> waiters_;
};

}  // namespace lcrig
