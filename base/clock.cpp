// SPDX-License-Identifier: Apache-2.0
#include "base/clock.hpp"

#include <algorithm>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <cassert>
#include <utility>

#include "base/as_result.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

// When a timer fires this late, the process had no processor time. Bytes that arrived in the
// meantime are still in the kernel.
constexpr Duration kStoodStill = 50ms;
constexpr Duration kCatchUp = 5ms;  // for reading those bytes

}  // namespace

Task<bool> Clock::wait_until(MonoTime t) {
  return wait(t, nullptr);
}

Task<bool> Clock::wait_until(MonoTime t, Wakeup& early) {
  return wait(t, &early);
}

Task<bool> Clock::wait_for(Duration d) {
  return wait_until(now() + d);
}

MonoTime RealClock::now() const {
  return MonoTime(
      std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}

std::int64_t RealClock::unix_ns() const {
  return std::chrono::duration_cast<Duration>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

// The timer of one wait, which a Wakeup may end early. Whichever of the two is destroyed first
// detaches itself from the other.
struct Wakeup::Sleeper {
  Sleeper(asio::any_io_executor executor, Wakeup* early)
      : timer(std::move(executor)), wakeup(early) {
    if (wakeup == nullptr) return;
    assert(wakeup->sleeper_ == nullptr);
    wakeup->sleeper_ = this;
  }
  ~Sleeper() {
    if (wakeup == nullptr) return;
    wakeup->sleeper_ = nullptr;
    wakeup->knocked_ = false;
  }
  Sleeper(const Sleeper&) = delete;
  Sleeper& operator=(const Sleeper&) = delete;
  static bool is_knocked(Wakeup* early) {
    return early != nullptr && std::exchange(early->knocked_, false);
  }

  asio::steady_timer timer;
  Wakeup* wakeup;
};

Wakeup::~Wakeup() {
  if (sleeper_ == nullptr) return;
  sleeper_->timer.cancel();
  sleeper_->wakeup = nullptr;
}

void Wakeup::notify() {
  knocked_ = true;
  if (sleeper_ != nullptr) sleeper_->timer.cancel();
}

Task<bool> RealClock::wait(MonoTime t, Wakeup* early) {
  if (Wakeup::Sleeper::is_knocked(early)) co_return false;
  Wakeup::Sleeper sleeper(co_await asio::this_coro::executor, early);
  asio::steady_timer& timer = sleeper.timer;
  const MonoTime due = std::max(t, now());
  timer.expires_at(std::chrono::steady_clock::time_point(t.time_since_epoch()));
  auto r = co_await timer.async_wait(kAsResult);
  if (!std::get<0>(r) && now() - due > kStoodStill) {
    // Read what has arrived first. Otherwise an instrument that answered in time would count as
    // silent.
    timer.expires_after(kCatchUp);
    r = co_await timer.async_wait(kAsResult);
  }
  co_return !std::get<0>(r);
}

// The timer never expires by itself. Virtual time, a Wakeup and a cancellation by Asio all end the
// wait by cancelling the timer; `fired` is true when virtual time did.
struct VirtualClock::Waiter : Wakeup::Sleeper {
  Waiter(asio::any_io_executor executor, Wakeup* early, VirtualClock& c, MonoTime t)
      : Sleeper(std::move(executor), early), clock(c), self(clock.waiters_.end()) {
    timer.expires_at(asio::steady_timer::time_point::max());
    // A deadline in the past fires at the next jump, not at once.
    if (t != MonoTime::max()) self = clock.waiters_.emplace(std::max(t, clock.now_), this);
  }
  ~Waiter() {
    if (self != clock.waiters_.end()) clock.waiters_.erase(self);
  }
  Waiter(const Waiter&) = delete;
  Waiter& operator=(const Waiter&) = delete;

  VirtualClock& clock;
  std::multimap<MonoTime, Waiter*>::iterator self;  // position in the queue; end() when not queued
  bool fired = false;
};

VirtualClock::VirtualClock(std::int64_t unix_start_ns) : unix_offset_ns_(unix_start_ns) {}

std::int64_t VirtualClock::unix_ns() const {
  return unix_offset_ns_ + now_.time_since_epoch().count();
}

Task<bool> VirtualClock::wait(MonoTime t, Wakeup* early) {
  if (Wakeup::Sleeper::is_knocked(early)) co_return false;
  Waiter waiter(co_await asio::this_coro::executor, early, *this, t);
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
  waiter->self = waiters_.end();
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
    // One call is enough: poll() runs handlers until none is ready.
    if (io.poll() > 0 && done()) return true;
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
