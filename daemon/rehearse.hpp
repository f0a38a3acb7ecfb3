// SPDX-License-Identifier: Apache-2.0
// Rehearses a run on the simulated bench, in virtual time and in this process: the daemon's App
// with another clock and simulated instruments. Used by `lcrig rehearse` and `lcrig protocol plan`.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/rig/bench.hpp"
#include "daemon/run_request.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

struct RehearseRequest : RunRequest, BenchChoice {
  std::string db_path;
  // Fault script (docs/faults.md); with an empty text nothing goes wrong.
  std::string faults_name, faults_text;
  // Answers of the simulated person (docs/protocol-file.md). Without a text: the defaults, or
  // something that fits.
  std::string answers_name, answers_text;
  // Called on the calling thread whenever the status changed; may be empty.
  std::function<void(const RunStatus&)> progress;
};

struct RehearseResult : RunOutcome {
  // Absent if the run did not measure them.
  std::optional<double> c0_pF, peak_force_N, delta_C_fF_at_peak;
  std::string db_path;
  std::int64_t faults = 0;  // number of faults of the script that happened
  std::vector<std::string> remarks;  // which results are not physics, and which answers were
                                     // invented
};

// Errors: invalid_request (protocol, parameters, specimen, bench, faults), io (database). A run
// that began and failed is a result, not an error.
Result<RehearseResult> rehearse(const RehearseRequest& request);

// For `lcrig protocol plan`: the capabilities of a bench's instruments and, with a specimen,
// estimates of the force to compress it. Errors: as rehearse.
struct BenchRequest : BenchChoice {
  std::string specimen_name, specimen_text;  // empty: no estimates for a specimen
  bool weights = false;  // a rod with dead weights instead of the frame
};
struct Rig;  // protocols/plan/check.hpp
Result<Rig> bench_rig(const BenchRequest& request);

}  // namespace lcrig
