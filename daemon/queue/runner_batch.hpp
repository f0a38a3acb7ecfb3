// SPDX-License-Identifier: Apache-2.0
// A table of runs on its way into the queue; inside daemon/queue only.
#pragma once

#include <string>
#include <vector>

#include "daemon/control/queue_handler.hpp"

namespace lcrig {

struct WantedBatch {
  BatchTable table;
  std::vector<BatchEntry> rows;
  std::vector<BatchTurn> turns;  // in the order of the queue
  // Different runs, each planned once; of every row which one, and on what terms.
  std::vector<RunRequest> kinds;
  std::vector<EntryPlan> plans;
  std::vector<std::size_t> kind_of_row;
  std::vector<QueueTerms> terms_of_row;
};
// Errors: invalid_request, all that is wrong with the table.
Result<WantedBatch> read_wanted_batch(const BatchAdd& wanted);

// As an entry is stored; runner_requests.cpp.
QueuedRun stored_form(const RunRequest& run, const QueueTerms& terms, const EntryPlan& plan);
// Errors: busy, when somebody else locked it.
Result<> not_locked(const Database& db, const QueueActor& who);

}  // namespace lcrig
