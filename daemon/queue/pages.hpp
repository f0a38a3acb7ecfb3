// SPDX-License-Identifier: Apache-2.0
// Reads the entries of the queue from a database. Used for the daemon's clients, and by `lcrig
// queue` while no daemon runs.
#pragma once

#include <cstdint>

#include "base/result.hpp"
#include "daemon/control/messages.hpp"
#include "daemon/control/queue_handler.hpp"
#include "storage/database.hpp"

namespace lcrig {

// Planned times count from `now_unix_ns`; the current run has `left_s` left. Errors: an unreadable
// database.
Result<QueuePage> read_queue_page(const Database& db, std::int64_t now_unix_ns, double left_s,
                                  std::int64_t skip, std::int64_t most);
// Errors: also invalid_request, when there is no such entry.
Result<ListedEntry> read_listed_entry(const Database& db, std::int64_t now_unix_ns, double left_s,
                                      std::int64_t entry);
// The status of a queue while no daemon runs: it is held, whatever the last daemon stored.
Result<QueueStatus> read_queue_at_rest(const Database& db);

}  // namespace lcrig
