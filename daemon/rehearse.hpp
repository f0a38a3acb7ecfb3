// SPDX-License-Identifier: Apache-2.0
// A whole run on the simulated bench in virtual time, in this process: the daemon's App with
// another clock and simulated instruments. `lcrig rehearse` and `lcrig protocol plan` call it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/run_request.hpp"
#include "model/bench_errors.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

struct RehearseRequest : RunRequest {
  std::string bench = "paper";  // a name, or "replay:DIR"
  std::string bench_text;  // of the bench file; empty: `bench` is one that the program knows
  std::optional<std::uint64_t> seed;  // absent: the bench's own
  std::optional<ErrorScope> errors;  // absent: as the bench file says
  std::optional<std::uint64_t> rig_seed;  // of the errors that last; absent: `seed`
  std::string db_path;
  // Fault script (docs/faults.md); an empty text: nothing goes wrong.
  std::string faults_name, faults_text;
  // Answers of its person (docs/protocol-file.md). An empty text: the defaults, or something that
  // fits.
  std::string answers_name, answers_text;
  // Called on the calling thread whenever the status changed; may be empty.
  std::function<void(const RunStatus&)> progress;
};

struct RehearseResult : RunOutcome {
  // Absent when the run did not measure it.
  std::optional<double> c0_pF, peak_force_N, delta_C_fF_at_peak;
  std::string db_path;
  std::int64_t faults = 0;  // that happened, of the script
  std::vector<std::string> remarks;  // what of it is no physics, and what nobody really answered
};

// Errors: invalid_request (protocol, parameters, specimen, bench, faults), io (database). A run
// that began and failed is a result, not an error.
Result<RehearseResult> rehearse(const RehearseRequest& request);

// For `lcrig protocol plan`: what that bench's instruments can do, and, with a specimen, what it
// will take to press it. Same errors.
struct BenchRequest {
  std::string bench = "paper", bench_text;  // as in RehearseRequest
  std::string specimen_name, specimen_text;  // empty: no estimates of the specimen
  bool weights = false;  // a rod with dead weights instead of the load frame
};
struct Rig;  // protocols/plan/check.hpp
Result<Rig> bench_rig(const BenchRequest& request);

}  // namespace lcrig
