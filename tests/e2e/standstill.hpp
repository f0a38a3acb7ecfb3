// SPDX-License-Identifier: Apache-2.0
// Measures when the machine itself stood still. A test in real time shares its processors with
// other programs, and a virtual machine sometimes loses them to its host (steal time). No program
// can be on time then. Used by tests that judge lateness or losses.
#pragma once

#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "base/time.hpp"

namespace lcrig::e2e {

// Runs a thread on each processor that sleeps 10 ms at a time and records when it was woken late.
class StandstillWatch {
 public:
  StandstillWatch();
  ~StandstillWatch();
  StandstillWatch(const StandstillWatch&) = delete;
  StandstillWatch& operator=(const StandstillWatch&) = delete;

  // For how long, within this time, at least one processor stood still for 10 ms or more.
  Duration within(MonoTime from, MonoTime to) const;
  Duration longest() const;  // longest standstill of one processor so far

 private:
  struct Interval {
    MonoTime from, to;
  };
  void watch(int processor, const std::stop_token& stop);

  mutable std::mutex mutex_;
  std::vector<Interval> intervals_;
  std::vector<std::jthread> threads_;  // declared last, so that they end first
};

}  // namespace lcrig::e2e
