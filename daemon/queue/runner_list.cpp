// SPDX-License-Identifier: Apache-2.0
// Requests to the queue that change nothing.
#include "daemon/queue/pages.hpp"
#include "daemon/queue/runner.hpp"

namespace lcrig {

Task<Result<QueuePage>> QueueRunner::list(std::int64_t skip, std::int64_t most) {
  const std::int64_t now = clock_.unix_ns();
  const double left_s = host_.left_s();
  const auto job = [=](const Database& db) { return read_queue_page(db, now, left_s, skip, most); };
  co_return co_await store_.with(job);
}

Task<Result<ListedEntry>> QueueRunner::show(std::int64_t entry) {
  const std::int64_t now = clock_.unix_ns();
  const double left_s = host_.left_s();
  const auto job = [=](const Database& db) { return read_listed_entry(db, now, left_s, entry); };
  co_return co_await store_.with(job);
}

Task<Result<std::vector<QueueAct>>> QueueRunner::history(std::optional<std::int64_t> entry,
                                                         std::int64_t before, std::int64_t most) {
  const auto job = [=](const Database& db) { return queue_history(db, entry, before, most); };
  co_return co_await store_.with(job);
}

}  // namespace lcrig
