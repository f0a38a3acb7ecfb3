// SPDX-License-Identifier: Apache-2.0
// Durations, points of monotonic time, and the interface of clocks, for code that stores or
// computes times. Code that awaits includes base/clock.hpp, which brings Asio.
#pragma once

#include <chrono>
#include <cstdint>

#include "base/task.hpp"

namespace lcrig {

using Duration = std::chrono::nanoseconds;
// Monotonic time of the run's clock, ns; in the database as `_mono_ns`.
struct MonoTag {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = Duration;
};
using MonoTime = std::chrono::time_point<MonoTag, Duration>;

constexpr Duration from_seconds(double s) {
  return Duration(static_cast<std::int64_t>(s * 1e9 + (s < 0 ? -0.5 : 0.5)));
}
constexpr double to_seconds(Duration d) {
  return static_cast<double>(d.count()) * 1e-9;
}
inline constexpr std::int64_t kSecond_ns = 1'000'000'000, kDay_ns = 86'400 * kSecond_ns;
inline constexpr double kLongestTime_s = 30 * 86400.0;  // the longest time that any file or command
                                                        // may ask for: 30 days

// Lets one coroutine end the wait of another on the same thread. It serves one waiter. A notify
// without a waiter is remembered and ends the next wait at once. A wait may also end without a
// reason, so the waiter checks its own condition in a loop.
class Wakeup {
 public:
  Wakeup() = default;
  ~Wakeup();
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;
  void notify();

 private:
  friend class RealClock;
  friend class VirtualClock;
  struct Sleeper;
  bool knocked_ = false;
  Sleeper* sleeper_ = nullptr;  // the wait under way, if any
};

class Clock {
 public:
  virtual ~Clock() = default;
  virtual MonoTime now() const = 0;
  virtual std::int64_t unix_ns() const = 0;  // wall clock, read once per run to anchor its
                                             // monotonic times
  // True when the time came, false when the wait was cancelled. Never throws and honours terminal
  // cancellation, so it may stand on either side of `||`. If the process got no processor time
  // until after `t`, pending input is read before this returns. Otherwise an instrument that
  // answered in time would count as silent.
  Task<bool> wait_until(MonoTime t);
  // The same, and false when `early` was notified. MonoTime::max() waits without a deadline.
  Task<bool> wait_until(MonoTime t, Wakeup& early);
  Task<bool> wait_for(Duration d);

 private:
  virtual Task<bool> wait(MonoTime t, Wakeup* early) = 0;
};

}  // namespace lcrig
