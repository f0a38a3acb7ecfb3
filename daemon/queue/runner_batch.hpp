// SPDX-License-Identifier: Apache-2.0
// A table of runs on its way into the queue; used inside daemon/queue only.
#pragma once

#include <vector>

#include "daemon/control/queue_handler.hpp"

namespace lcrig {

struct WantedBatch {
  BatchTable table;
  std::vector<BatchEntry> rows;
  std::vector<BatchTurn> turns;  // in the order in which they are queued
  // Different runs, each planned once; and for each row its kind and its terms.
  std::vector<RunRequest> kinds;
  std::vector<EntryPlan> plans;
  std::vector<std::size_t> kind_of_row;
  std::vector<QueueTerms> terms_of_row;
};
// Errors: invalid_request, with all mistakes of the table.
Result<WantedBatch> read_wanted_batch(const BatchAdd& wanted);

// The form in which an entry is stored; defined in runner_requests.cpp.
QueuedRun stored_form(const RunRequest& run, const QueueTerms& terms, const EntryPlan& plan);
// Errors: busy, when somebody else locked the queue.
Result<> not_locked(const Database& db, const QueueActor& who);

}  // namespace lcrig
