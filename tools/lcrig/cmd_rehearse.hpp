// SPDX-License-Identifier: Apache-2.0
// The seam to the daemon's App (daemon/rehearse.hpp): everything else of the command line does
// without it, and main.cpp alone names the real functions.
#pragma once

#include "base/result.hpp"

namespace lcrig {

struct RehearseRequest;
struct RehearseResult;
struct RehearseBatchRequest;
struct RehearseBatchResult;
struct BenchRequest;
struct Rig;
Result<RehearseResult> rehearse(const RehearseRequest& request);
Result<RehearseBatchResult> rehearse_batch(const RehearseBatchRequest& request);
Result<Rig> bench_rig(const BenchRequest& request);

namespace cli {
struct DaemonParts {
  Result<RehearseResult> (*rehearse)(const RehearseRequest&) = nullptr;
  Result<RehearseBatchResult> (*rehearse_batch)(const RehearseBatchRequest&) = nullptr;
  Result<Rig> (*bench_rig)(const BenchRequest&) = nullptr;
};
}  // namespace cli

}  // namespace lcrig
