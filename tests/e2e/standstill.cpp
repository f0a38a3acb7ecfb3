// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/standstill.hpp"

#include <sched.h>

#include <algorithm>
#include <ctime>

#include "base/clock.hpp"

namespace lcrig::e2e {

namespace {

using namespace std::chrono_literals;

constexpr Duration kTick = 10ms;
constexpr Duration kLate = 10ms;  // shorter delays are normal scheduling

void sleep_until(MonoTime t) {
  const auto ns = t.time_since_epoch().count();
  const timespec until{ns / 1'000'000'000, ns % 1'000'000'000};
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

}  // namespace

StandstillWatch::StandstillWatch() {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  ::sched_getaffinity(0, sizeof allowed, &allowed);
  for (int i = 0; i < CPU_SETSIZE; ++i) {
    if (!CPU_ISSET(i, &allowed)) continue;
    threads_.emplace_back([this, i](const std::stop_token& stop) { watch(i, stop); });
  }
}

StandstillWatch::~StandstillWatch() {
  for (auto& thread : threads_) thread.request_stop();
}

void StandstillWatch::watch(int processor, const std::stop_token& stop) {
  cpu_set_t only;
  CPU_ZERO(&only);
  CPU_SET(processor, &only);
  ::sched_setaffinity(0, sizeof only, &only);
  const RealClock clock;
  while (!stop.stop_requested()) {
    const MonoTime due = clock.now() + kTick;
    sleep_until(due);
    const MonoTime woken = clock.now();
    if (woken - due < kLate) continue;
    const std::lock_guard lock(mutex_);
    intervals_.push_back({due, woken});
  }
}

Duration StandstillWatch::within(MonoTime from, MonoTime to) const {
  std::vector<Interval> in;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& i : intervals_) {
      if (i.to > from && i.from < to) in.push_back({std::max(i.from, from), std::min(i.to, to)});
    }
  }
  std::ranges::sort(in, {}, &Interval::from);
  Duration sum{};
  MonoTime counted = from;
  for (const auto& i : in) {
    if (i.to <= counted) continue;
    sum += i.to - std::max(i.from, counted);
    counted = i.to;
  }
  return sum;
}

Duration StandstillWatch::longest() const {
  const std::lock_guard lock(mutex_);
  Duration longest{};
  for (const auto& i : intervals_) longest = std::max(longest, i.to - i.from);
  return longest;
}

}  // namespace lcrig::e2e
