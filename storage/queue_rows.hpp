// SPDX-License-Identifier: Apache-2.0
// Writes queue rows for both single entries and batches. Used inside storage/ only.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "storage/queue.hpp"

namespace lcrig {

using QueuedRuns = std::function<const QueuedRun*(std::size_t)>;  // by index, from 0

// Stores a text unless it is stored already. Returns its hash.
Result<std::string> store_queue_text(const Database& db, const std::string& text);
// Inserts `count` runs; call it within a transaction. `why` is added to the history.
Result<std::vector<std::int64_t>> insert_into_queue(const Database& db, std::size_t count,
                                                    const QueuedRuns& run_at, QueuePlace place,
                                                    const QueueActor& who,
                                                    std::string_view why = {});
Result<> set_entry_state(const Database& db, std::int64_t entry, EntryState state);

}  // namespace lcrig
