// SPDX-License-Identifier: Apache-2.0
// Counts the tasks of the ports and of the back door, so that lcrig-sim can end when all of them
// have ended.
#pragma once

#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <functional>
#include <utility>

#include "base/condition.hpp"

namespace lcrig::sim {

// It must outlive its tasks and those who start them.
class Tasks {
 public:
  Tasks(asio::any_io_executor executor, Clock& clock)
      : executor_(std::move(executor)), changed_(clock) {}

  // `at_end` is called once the task has ended. It keeps alive what the task uses.
  void start(Task<> task, std::function<void()> at_end = {}) {
    ++running_;
    const auto ended = [this, at_end = std::move(at_end)](std::exception_ptr error) {
      --running_;
      if (at_end) at_end();
      changed_.notify_all();
      if (error) std::rethrow_exception(error);
    };
    asio::co_spawn(executor_, std::move(task), ended);
  }
  // Waits until `holds()` is true. It is asked again whenever a task ends.
  Task<bool> until(std::function<bool()> holds, MonoTime limit) {
    return changed_.wait(std::move(holds), limit);
  }
  Task<bool> all_ended(MonoTime limit) {
    return until([this] { return running_ == 0; }, limit);
  }

 private:
  asio::any_io_executor executor_;
  Condition changed_;
  int running_ = 0;
};

}  // namespace lcrig::sim
