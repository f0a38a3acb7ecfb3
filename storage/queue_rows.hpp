// SPDX-License-Identifier: Apache-2.0
// Rows of the queue that batches and the queue write alike; inside storage/ only.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "storage/queue.hpp"

namespace lcrig {

using QueuedRuns = std::function<const QueuedRun*(std::size_t)>;  // by index, from 0 on

// Stores a text unless it is there. Returns its hash.
Result<std::string> store_queue_text(const Database& db, const std::string& text);
// To be called within a transaction, for `count` runs. `why`: for the history, beside the place.
Result<std::vector<std::int64_t>> insert_into_queue(const Database& db, std::size_t count,
                                                    const QueuedRuns& run_at, QueuePlace place,
                                                    const QueueActor& who,
                                                    std::string_view why = {});
EntryState read_entry_state(std::string_view word);

}  // namespace lcrig
