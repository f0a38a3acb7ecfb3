// SPDX-License-Identifier: Apache-2.0
// How one coroutine wakes another on the same thread, in real and in virtual time.
#pragma once

#include <memory>

#include "base/clock.hpp"

namespace lcrig {

// A remembered knock for one waiter: a notify without a waiter ends the next wait at once. A wait
// may end for no reason, so the waiter looks at its own condition in a loop. Waits honour
// cancellation and never throw; they may stand on either side of `||`.
class Wakeup {
 public:
  explicit Wakeup(asio::any_io_executor executor);
  ~Wakeup();
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;

  void notify();
  Task<> wait();
  Task<> wait_until(Clock& clock, MonoTime deadline);

 private:
  struct Channel;
  std::unique_ptr<Channel> channel_;
};

}  // namespace lcrig
