// SPDX-License-Identifier: Apache-2.0
// A whole day on the simulated bench in virtual time: the daemon's App with its queue, and somebody
// who acts at the gates. `lcrig rehearse --batch` calls it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/control/queue_handler.hpp"
#include "model/bench_errors.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

struct RehearseBatchRequest {
  BatchAdd batch;  // stored as NAME-2, NAME-3 where the name exists
  std::string bench = "paper", bench_text;  // as in RehearseRequest
  std::optional<std::uint64_t> noise_seed;  // of the first run, one more for each; else the bench's
  std::optional<ErrorScope> errors;
  std::string db_path;
  double hand_s = 120;  // what a person takes, each time
  std::int64_t begin_unix_ns = 0;
  std::function<void(const RunStatus&)> progress;  // as in RehearseRequest
};

// When somebody has to do what.
struct HandTime {
  double at_s = 0;  // since the queue was started
  std::int64_t entry = 0;
  std::optional<QueueGate> gate;  // nullopt: the queue held
  std::string prompt;
};
struct RehearsedEntry : BatchListing {  // at the end
  std::optional<std::int64_t> run;
  std::optional<ExitStatus> exit_status;  // of the run
  std::string reason;
  std::int64_t measure_readings = 0;
  double duration_s = 0;
  std::int64_t acts = 0;  // of a person inside its runs: weights, confirmations, answers
};
struct RehearseBatchResult {
  std::string name, db_path;
  double length_s = 0, machine_s = 0, hands_s = 0;
  std::int64_t measure_readings = 0;
  std::vector<RehearsedEntry> entries;  // in their order
  std::vector<HandTime> hands;
  std::vector<std::string> troubles;  // what held the queue, and entries that did not succeed
  double wall_s = 0;
};

// Errors: invalid_request (the table, the bench, a database with a queue of its own), io. A failure
// on the day is a result and no error: the simulated person skips the entry, and the result tells
// it.
Result<RehearseBatchResult> rehearse_batch(const RehearseBatchRequest& request);

}  // namespace lcrig
