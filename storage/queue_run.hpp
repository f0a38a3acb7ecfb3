// SPDX-License-Identifier: Apache-2.0
// Begins and ends entries of the queue, and starts and holds the queue, each in one transaction.
// The daemon's queue runner uses it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "storage/queue.hpp"

namespace lcrig {

// Begins the entry as run `run`. In the transaction that writes the row of that run, so that both
// are there or neither is. Errors: aborted when the queue is held, or the entry is not the first
// one that waits; then the run must not begin.
Result<> claim_queue_entry(const Database& db, std::int64_t entry, std::int64_t run,
                           std::int64_t now_unix_ns);
// A run of anybody says which specimen is on the rig. In the same transaction.
Result<> note_specimen_of_run(const Database& db, std::string_view specimen);

// The new state of the head after an attempt, or after it could not be begun.
struct EntryEnd {
  EntryState state = EntryState::failed;
  std::optional<HoldCause> hold;  // nullopt: the queue goes on
  std::string why;  // it holds
  std::int64_t failures_in_row = 0;
  std::string detail;  // for the history
};
Result<> end_queue_entry(const Database& db, std::int64_t entry, const EntryEnd& end,
                         const QueueActor& who);

// Errors: invalid_request when the head needs a choice, or another one; io.
Result<> start_queue(const Database& db, HeadChoice choice, const QueueActor& who);
// A queue that does not go keeps its reason.
Result<> hold_queue(const Database& db, HoldCause cause, std::string_view why,
                    const QueueActor& who);

// After a daemon ended without ending its entry, however that was: a run that had ended tells how
// the entry did; one that was cut off leaves it interrupted. The queue does not go. Only the sole
// writer may call it, after close_orphaned_runs. True: it was going, or an entry was running.
Result<bool> settle_queue(const Database& db, std::int64_t now_unix_ns);

}  // namespace lcrig
