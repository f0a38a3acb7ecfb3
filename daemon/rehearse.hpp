// SPDX-License-Identifier: Apache-2.0
// A whole run on the simulated bench in virtual time, in this process: the daemon's own App, driver
// and recorder; only clock and transports differ.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/exit_status.hpp"
#include "base/result.hpp"
#include "protocols/file/parse.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

struct RehearseRequest {
  RehearseRequest() = default;
  std::string protocol_name, protocol_text;
  ParameterValues parameters;
  std::string specimen_name, specimen_text;
  std::string bench = "paper";  // a name, or "replay:DIR"
  std::string bench_text;  // of the bench file; empty: `bench` is one that the program knows
  std::optional<std::uint64_t> seed;  // absent: the bench's own
  std::string db_path;
  std::string operator_name, note;
  // Fault script (docs/faults.md); an empty text: nothing goes wrong.
  std::string faults_name, faults_text;
  // Called on the calling thread whenever the status changed; may be empty.
  std::function<void(const RunStatus&)> progress;
};

struct RehearseResult {
  RehearseResult() = default;
  std::int64_t run = 0;
  ExitStatus exit_status = ExitStatus::fail;
  std::optional<Errc> code;  // why, when it was not a success
  std::string reason;
  std::int64_t lcr_readings = 0, measure_readings = 0, frame_samples = 0;
  double duration_s = 0;  // of the rig
  double wall_s = 0;  // of this computer
  // Absent when the run did not measure it.
  std::optional<double> c0_pF, peak_force_N, delta_C_fF_at_peak;
  std::string db_path;
  std::int64_t faults = 0;  // that happened, of the script
};

// Errors: invalid_request (protocol, parameters, specimen, bench, faults), io (database). A run
// that began and failed is a result, not an error.
Result<RehearseResult> rehearse(const RehearseRequest& request);

// For `lcrig protocol plan`: what that bench's instruments can do, and, with a specimen, what it
// will take to press it. Same errors.
struct BenchRequest {
  BenchRequest() = default;
  std::string bench = "paper", bench_text;  // as in RehearseRequest
  std::string specimen_name, specimen_text;  // empty: no estimates of the specimen
  bool weights = false;  // a rod with dead weights instead of the load frame
};
struct Rig;  // protocols/plan/check.hpp
Result<Rig> bench_rig(const BenchRequest& request);

}  // namespace lcrig
