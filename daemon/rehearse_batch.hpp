// SPDX-License-Identifier: Apache-2.0
// Rehearses a whole day on the simulated bench in virtual time: the daemon's App with its queue,
// and a simulated person at the gates. Used by `lcrig rehearse --batch`.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/control/queue_handler.hpp"
#include "daemon/rig/bench.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

// `seed` is that of the first run; each run after it takes the next number.
struct RehearseBatchRequest : BenchChoice {
  BatchAdd batch;  // stored as NAME-2, NAME-3 if the name exists
  std::string db_path;
  double hand_s = 120;  // time that a person takes for each act
  std::int64_t begin_unix_ns = 0;
  std::function<void(const RunStatus&)> progress;  // as in RehearseRequest
};

// An act of a person, and its time.
struct HandTime {
  double at_s = 0;  // since the start of the queue
  std::int64_t entry = 0;
  std::optional<QueueGate> gate;  // nullopt: the queue was held
  std::string prompt;
};
struct RehearsedEntry : BatchListing {  // as it was at the end
  std::optional<std::int64_t> run;
  std::optional<ExitStatus> exit_status;  // of the run
  std::string reason;
  std::int64_t measure_readings = 0;
  double duration_s = 0;
  std::int64_t acts = 0;  // acts of a person during its runs: weights, confirmations, answers
};
struct RehearseBatchResult {
  std::string name, db_path;
  double length_s = 0, machine_s = 0, hands_s = 0;
  std::int64_t measure_readings = 0;
  std::vector<RehearsedEntry> entries;  // in the order of the queue
  std::vector<HandTime> hands;
  std::vector<std::string> troubles;  // causes of holds, and entries without success
  double wall_s = 0;
};

// Errors: invalid_request (the table, the bench, a database with a queue of its own), io. A failure
// of an entry is not an error: the simulated person skips the entry, and the result reports it.
Result<RehearseBatchResult> rehearse_batch(const RehearseBatchRequest& request);

}  // namespace lcrig
