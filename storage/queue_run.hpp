// SPDX-License-Identifier: Apache-2.0
// Begins and ends entries of the queue, and starts and holds the queue. Each function is one
// transaction unless it says otherwise. Used by the daemon's queue runner.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "storage/queue.hpp"

namespace lcrig {

// Begins the entry as run `run`. Call it in the transaction that writes the row of that run, so
// that both are stored or neither. Errors: aborted when the queue is held, or the entry is not the
// first that waits; then the run must not begin.
Result<> claim_queue_entry(const Database& db, std::int64_t entry, std::int64_t run,
                           std::int64_t now_unix_ns);
// Stores which specimen is on the rig, from the row of any run. Call it in the transaction of that
// row.
Result<> note_specimen_of_run(const Database& db, std::string_view specimen);

// The new state of the head after an attempt, or after the attempt could not begin.
struct EntryEnd {
  EntryState state = EntryState::failed;
  std::optional<HoldCause> hold;  // nullopt: the queue goes on
  std::string why;  // reason of the hold
  std::int64_t failures_in_row = 0;
  std::string detail;  // for the history
};
Result<> end_queue_entry(const Database& db, std::int64_t entry, const EntryEnd& end,
                         const QueueActor& who);

// Errors: invalid_request when the head needs a choice, or another one; io.
Result<> start_queue(const Database& db, HeadChoice choice, const QueueActor& who);
// Does nothing to a queue that is held already: it keeps its reason.
Result<> hold_queue(const Database& db, HoldCause cause, std::string_view why,
                    const QueueActor& who);

// Called at the start, in case the last daemon did not end its entry. If the run of that entry has
// ended, its end decides the entry's state; if it was cut off, the entry is interrupted. The queue
// is held. Only the sole writer may call it, after close_orphaned_runs. True: the queue was going,
// or an entry was running.
Result<bool> settle_queue(const Database& db, std::int64_t now_unix_ns);

}  // namespace lcrig
