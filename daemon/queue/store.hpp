// SPDX-License-Identifier: Apache-2.0
// The queue's own connection to the database. It works aside, because another program may lock the
// database for seconds. One job at a time. Used by QueueRunner.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "base/aside.hpp"
#include "base/condition.hpp"
#include "daemon/record/room.hpp"
#include "storage/database.hpp"

namespace lcrig {

class QueueStore {
 public:
  // `clock` must outlive it. The database must exist.
  QueueStore(asio::any_io_executor executor, Clock& clock, std::string path, std::string vfs)
      : executor_(std::move(executor)),
        clock_(clock),
        path_(std::move(path)),
        vfs_(std::move(vfs)),
        free_(clock) {}

  // Runs `job` and returns its Result, or the error of opening the database.
  template <class Job>
  Task<std::invoke_result_t<Job&, const Database&>> with(Job job) {
    using JobResult = std::invoke_result_t<Job&, const Database&>;
    const auto is_free = [this] { return !busy_; };
    co_await free_.wait(is_free);
    busy_ = true;
    const auto aside = [this, &job]() -> JobResult {
      if (auto there = connect(); !there) return fail(there.error());
      auto answer = job(std::as_const(*db_));
      // After an I/O error a connection cannot be trusted.
      if (!answer && db_->needs_reopening()) db_.reset();
      return answer;
    };
    auto answer = co_await run_aside(executor_, clock_, aside);
    busy_ = false;
    free_.notify_all();
    co_return answer;
  }
  // Returns when no job is in progress.
  Task<> settle() {
    const auto is_free = [this] { return !busy_; };
    co_await free_.wait(is_free);
  }
  // Checks the disk for the waiting runs. Each run is checked again when it begins.
  Result<> check_room(std::int64_t bytes) const { return require_room(path_, bytes); }

 private:
  Result<> connect() { return db_ ? Result<>() : keep(open_read_write(path_, vfs_), db_); }

  asio::any_io_executor executor_;
  Clock& clock_;
  std::string path_, vfs_;
  std::optional<Database> db_;
  Condition free_;
  bool busy_ = false;
};

}  // namespace lcrig
