// SPDX-License-Identifier: Apache-2.0
// Runs work on a thread of its own when it takes longer than the thread of the instruments may
// pause: reading a large file, planning two million steps, the finite elements of a specimen,
// opening a slow port. The daemon uses it.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/this_coro.hpp>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <type_traits>
#include <utility>

#include "base/as_result.hpp"
#include "base/clock.hpp"

namespace lcrig {

// Stops virtual time while it lives, because a job on another thread takes no virtual time.
class StillTime {
 public:
  explicit StillTime(Clock& clock) {
    if (auto* virtual_clock = dynamic_cast<VirtualClock*>(&clock)) hold_.emplace(*virtual_clock);
  }

 private:
  std::optional<VirtualClock::Hold> hold_;
};

namespace detail {

// The end of a job. `tell` runs on the loop, where the caller waits. The handler that calls it may
// run after that caller is gone, so both share this object.
struct Done {
  explicit Done(const asio::any_io_executor& executor) : channel(executor, 1) {}
  void tell() {
    is_told = true;
    channel.try_send(boost::system::error_code());
  }
  asio::experimental::channel<void(boost::system::error_code)> channel;
  bool is_told = false;
};

}  // namespace detail

// Runs `job` on a thread of its own and returns its result, while the loop of `executor` goes on.
// The data that the job uses must not change until then, so even a caller that is cancelled waits
// for the job. Virtual time stands still. Callers limit how many jobs run at once.
template <class Job>
Task<std::invoke_result_t<Job&>> run_aside(asio::any_io_executor executor, Clock& clock, Job job) {
  const StillTime still(clock);
  const auto work = asio::make_work_guard(executor);
  const auto done = std::make_shared<detail::Done>(executor);
  std::optional<std::invoke_result_t<Job&>> out;
  std::exception_ptr bug;
  std::jthread worker([&, done] {
    try {
      out.emplace(job());
    } catch (...) {
      bug = std::current_exception();
    }
    asio::post(executor, [done] { done->tell(); });
  });
  const bool throws = co_await asio::this_coro::throw_if_cancelled();
  co_await asio::this_coro::throw_if_cancelled(false);
  while (!done->is_told) co_await done->channel.async_receive(kAsResult);
  co_await asio::this_coro::throw_if_cancelled(throws);
  worker.join();
  if (bug) std::rethrow_exception(bug);
  co_return std::move(*out);
}

namespace detail {

template <class Job>
struct Handover {
  Handover(const asio::any_io_executor& e, Job j)
      : job(std::move(j)), executor(e), done(std::make_shared<Done>(e)) {}
  Job job;
  std::mutex mutex;  // guards the members below
  asio::any_io_executor executor;
  std::shared_ptr<Done> done;  // nullptr: the caller is gone, and perhaps the loop too
  std::optional<std::invoke_result_t<Job&>> out;
};

template <class Job>
void work_aside(const std::shared_ptr<Handover<Job>>& shared) {
  std::optional<std::invoke_result_t<Job&>> out(shared->job());
  const std::lock_guard lock(shared->mutex);
  if (!shared->done) return;
  shared->out = std::move(out);
  asio::post(shared->executor, [done = shared->done] { done->tell(); });
}

}  // namespace detail

// The same for a job that owns all its data and throws nothing: a caller that is cancelled gets
// nullopt and does not wait. The late result is destroyed on the job's thread.
template <class Job>
Task<std::optional<std::invoke_result_t<Job&>>> run_abandonable(asio::any_io_executor executor,
                                                                Clock& clock, Job job) {
  const StillTime still(clock);
  const auto shared = std::make_shared<detail::Handover<Job>>(executor, std::move(job));
  const auto done = shared->done;
  struct Leave {
    ~Leave() {
      const std::lock_guard lock(shared.mutex);
      shared.done.reset();
    }
    detail::Handover<Job>& shared;
  } const leave{*shared};
  const auto work = asio::make_work_guard(executor);
  try {
    std::thread([shared] { detail::work_aside(shared); }).detach();
  } catch (const std::system_error&) {  // no more threads: run it on this one
    detail::work_aside(shared);
  }
  co_await done->channel.async_receive(kAsResult);
  const std::lock_guard lock(shared->mutex);
  co_return std::move(shared->out);
}

}  // namespace lcrig
