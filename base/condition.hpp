// SPDX-License-Identifier: Apache-2.0
// A condition that coroutines of one thread wait for without polling. Another coroutine, or a
// callback on this thread, makes it true. Used by the daemon's app, queue and control socket.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "base/clock.hpp"

namespace lcrig {

class Condition {
 public:
  explicit Condition(Clock& clock) : clock_(clock) {}

  // Call this after each change of something that a coroutine may wait for.
  void notify_all() {
    for (Wakeup* sleeper : *sleepers_) sleeper->notify();
  }

  // True as soon as `holds()`; false when the deadline came first. The clock must outlive the wait;
  // this object need not.
  template <class Holds>
  Task<bool> wait(Holds holds, MonoTime deadline = MonoTime::max()) {
    Clock& clock = clock_;
    const Sleeper sleeper(sleepers_);
    while (!holds()) {
      if (clock.now() >= deadline) co_return false;
      co_await clock.wait_until(deadline, *sleeper.wakeup);
    }
    co_return true;
  }

 private:
  using Sleepers = std::vector<Wakeup*>;
  // One wait, registered with the condition while it lasts.
  struct Sleeper {
    explicit Sleeper(std::shared_ptr<Sleepers> others) : all(std::move(others)) {
      all->push_back(wakeup.get());
    }
    ~Sleeper() { std::erase(*all, wakeup.get()); }
    Sleeper(const Sleeper&) = delete;
    Sleeper& operator=(const Sleeper&) = delete;
    std::unique_ptr<Wakeup> wakeup = std::make_unique<Wakeup>();
    std::shared_ptr<Sleepers> all;
  };

  Clock& clock_;
  std::shared_ptr<Sleepers> sleepers_ = std::make_shared<Sleepers>();
};

}  // namespace lcrig
