// SPDX-License-Identifier: Apache-2.0
// Starts a coroutine that nobody awaits. The daemon and the simulators use it.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <utility>

#include "base/clock.hpp"

namespace lcrig {

// An exception that leaves the coroutine is a bug. It propagates out of `io_context::run`, so that
// the program reports it and dies. The gateway's watchdog and the next start make the frame safe.
inline void spawn(const asio::any_io_executor& executor, Task<> task) {
  asio::co_spawn(executor, std::move(task), [](const std::exception_ptr& bug) {
    if (bug) std::rethrow_exception(bug);
  });
}

}  // namespace lcrig
