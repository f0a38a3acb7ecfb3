// SPDX-License-Identifier: Apache-2.0
// When did the machine itself stand still? A test in real time shares its processors with others,
// and a virtual one loses them to its host for a while (steal time): no program is on time then.
#pragma once

#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "base/clock.hpp"

namespace lcrig::e2e {

// A thread on each processor that sleeps 10 ms at a time and notes when it was woken late.
class StandstillWatch {
 public:
  StandstillWatch();
  ~StandstillWatch();
  StandstillWatch(const StandstillWatch&) = delete;
  StandstillWatch& operator=(const StandstillWatch&) = delete;

  // How much of this time at least one processor stood still for 10 ms or more.
  Duration within(MonoTime from, MonoTime to) const;
  Duration longest() const;  // of one processor, so far

 private:
  struct Interval {
    MonoTime from, to;
  };
  void watch(int processor, const std::stop_token& stop);

  mutable std::mutex mutex_;
  std::vector<Interval> intervals_;
  std::vector<std::jthread> threads_;  // last: they end first
};

}  // namespace lcrig::e2e
