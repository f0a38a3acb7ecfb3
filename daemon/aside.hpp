// SPDX-License-Identifier: Apache-2.0
// Work that takes longer than the thread that runs the instruments may pause: reading a large file,
// planning two million steps, the finite elements of a specimen.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <boost/asio/post.hpp>
#include <exception>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>

#include "base/as_result.hpp"
#include "base/clock.hpp"

namespace lcrig {

// Virtual time stands still while this lives: a thread takes none of it.
class StillTime {
 public:
  explicit StillTime(Clock& clock) {
    if (auto* virtual_clock = dynamic_cast<VirtualClock*>(&clock)) hold_.emplace(*virtual_clock);
  }

 private:
  std::optional<VirtualClock::Hold> hold_;
};

// Runs `job` on a thread of its own and returns what it returned; the loop of `executor` goes on
// meanwhile. What the job uses must not change until then. Virtual time stands still. Whoever
// calls this limits how many are under way.
template <class Job>
Task<std::invoke_result_t<Job&>> run_aside(asio::any_io_executor executor, Clock& clock, Job job) {
  const StillTime still(clock);
  const auto work = asio::make_work_guard(executor);
  asio::experimental::channel<void(boost::system::error_code)> done(executor, 1);
  std::optional<std::invoke_result_t<Job&>> out;
  std::exception_ptr bug;
  std::jthread worker([&] {
    try {
      out.emplace(job());
    } catch (...) {
      bug = std::current_exception();
    }
    asio::post(executor, [&done] { done.try_send(boost::system::error_code()); });
  });
  co_await done.async_receive(kAsResult);
  worker.join();
  if (bug) std::rethrow_exception(bug);
  co_return std::move(*out);
}

}  // namespace lcrig
