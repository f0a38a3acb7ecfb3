// SPDX-License-Identifier: Apache-2.0
// Stores batches: a batch is the set of queue entries that one table of runs asked for. Used by the
// queue, `lcrig report --batch` and shell completion.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "storage/queue.hpp"

namespace lcrig {

struct StoredBatch {
  std::int64_t batch = 0;
  std::string name, file_name;
  BatchOrder order = BatchOrder::given;
  std::optional<std::int64_t> seed;  // of an order that was drawn at random
  std::string added_by;
  std::int64_t added_unix_ns = 0;
};

// "in blocks, seed 1234"
std::string order_words(BatchOrder order, std::int64_t seed);

// A run of a batch, and its row in the table. `run` is valid until the next one is asked for.
struct BatchedRun {
  const QueuedRun* run = nullptr;
  std::int64_t line = 1, repeat = 1;
};
using BatchedRuns = std::function<BatchedRun(std::size_t)>;

// Queues `count` runs in this order, all or none; `run_at(i)` gives the run at index i, from 0.
// `file_text` is the table as written. Returns the numbers of the entries. Errors: invalid_request
// (a batch of that name exists), and those of add_to_queue.
Result<std::vector<std::int64_t>> add_batch_to_queue(const Database& db, const StoredBatch& batch,
                                                     std::string_view file_text, std::size_t count,
                                                     const BatchedRuns& run_at, QueuePlace place,
                                                     const QueueActor& who);

// Errors: invalid_request when a batch of that name exists.
Result<> check_batch_name(const Database& db, std::string_view name);
Result<std::optional<StoredBatch>> find_batch(const Database& db, std::string_view name);
Result<std::vector<StoredBatch>> list_batches(const Database& db);  // newest first

// The state of one run of a batch.
struct BatchListing {
  std::int64_t position = 0, line = 0, repeat = 0;
  std::int64_t entry = 0;
  EntryState state = EntryState::waiting;
  std::string protocol_name, parameters_json, specimen_name, note;
  std::vector<std::int64_t> runs;  // its attempts
};
Result<std::vector<BatchListing>> batch_entries(const Database& db, std::int64_t batch);

// The batch that an entry belongs to; nullopt when it was queued alone.
struct EntryBatch {
  StoredBatch batch;
  std::int64_t position = 0, of = 0, line = 0, repeat = 0;
};
Result<std::optional<EntryBatch>> batch_of_entry(const Database& db, std::int64_t entry);

}  // namespace lcrig
