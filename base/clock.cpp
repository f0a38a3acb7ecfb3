// SPDX-License-Identifier: Apache-2.0
#include "base/clock.hpp"

#include <algorithm>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>

#include "base/as_result.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

// A loop that comes back so much later than it was to had no processor, and whatever arrived
// meanwhile is still in the kernel.
constexpr Duration kStoodStill = 50ms;
constexpr Duration kCatchUp = 5ms;  // time to read it

}  // namespace

MonoTime RealClock::now() const {
  return MonoTime(
      std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}

std::int64_t RealClock::unix_ns() const {
  return std::chrono::duration_cast<Duration>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

Task<bool> RealClock::wait_until(MonoTime t) {
  asio::steady_timer timer(co_await asio::this_coro::executor);
  const MonoTime due = std::max(t, now());
  timer.expires_at(std::chrono::steady_clock::time_point(t.time_since_epoch()));
  auto r = co_await timer.async_wait(kAsResult);
  if (!std::get<0>(r) && now() - due > kStoodStill) {
    // Arrivals first: else a deadline would call those silent who answered in time.
    timer.expires_after(kCatchUp);
    r = co_await timer.async_wait(kAsResult);
  }
  co_return !std::get<0>(r);
}

// The timer never expires by itself: cancelling it is how virtual time wakes the coroutine, and how
// Asio cancels it. `fired` tells the two apart.
struct VirtualClock::Waiter {
  Waiter(asio::any_io_executor ex, VirtualClock& c) : timer(std::move(ex)), clock(c) {
    timer.expires_at(asio::steady_timer::time_point::max());
  }
  ~Waiter() {
    if (!fired) clock.waiters_.erase(self);
  }
  Waiter(const Waiter&) = delete;
  Waiter& operator=(const Waiter&) = delete;

  asio::steady_timer timer;
  VirtualClock& clock;
  std::multimap<MonoTime, Waiter*>::iterator self{};
  bool fired = false;
};

VirtualClock::VirtualClock(std::int64_t unix_start_ns) : unix_offset_ns_(unix_start_ns) {}

std::int64_t VirtualClock::unix_ns() const {
  return unix_offset_ns_ + now_.time_since_epoch().count();
}

Task<bool> VirtualClock::wait_until(MonoTime t) {
  if (t <= now_) t = now_;  // a deadline in the past fires at the next jump, never in between
  Waiter waiter(co_await asio::this_coro::executor, *this);
  waiter.self = waiters_.emplace(t, &waiter);
  auto r = co_await waiter.timer.async_wait(kAsResult);
  static_cast<void>(r);
  co_return waiter.fired;
}

bool VirtualClock::advance_to_next() {
  if (waiters_.empty()) return false;
  auto it = waiters_.begin();
  Waiter* waiter = it->second;
  now_ = std::max(now_, it->first);
  waiters_.erase(it);
  waiter->fired = true;
  waiter->timer.cancel();
  return true;
}

bool VirtualClock::run(asio::io_context& io, const std::function<bool()>& done) {
  return pump(io, done, MonoTime::max());
}

void VirtualClock::run_for(asio::io_context& io, Duration d) {
  const MonoTime end = now_ + d;
  pump(io, [] { return false; }, end);
  now_ = end;
}

bool VirtualClock::pump(asio::io_context& io, const std::function<bool()>& done, MonoTime end) {
  const auto work = asio::make_work_guard(io);
  while (!done()) {
    if (io.stopped()) io.restart();
    if (io.poll() > 0) continue;
    if (holds_ > 0) {
      io.run_one();
    } else if (waiters_.empty() || waiters_.begin()->first > end) {
      return false;
    } else {
      advance_to_next();
    }
  }
  return true;
}

}  // namespace lcrig
