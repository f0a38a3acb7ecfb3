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
struct ConfigView;
Result<RehearseResult> rehearse(const RehearseRequest& request);
Result<RehearseBatchResult> rehearse_batch(const RehearseBatchRequest& request);
Result<Rig> bench_rig(const BenchRequest& request);
Result<ConfigView> look_at_config_file(const std::string& file);

namespace cli {
struct DaemonParts {
  Result<RehearseResult> (*rehearse)(const RehearseRequest&) = nullptr;
  Result<RehearseBatchResult> (*rehearse_batch)(const RehearseBatchRequest&) = nullptr;
  Result<Rig> (*bench_rig)(const BenchRequest&) = nullptr;
  Result<ConfigView> (*config)(const std::string& file) = nullptr;
};
}  // namespace cli

}  // namespace lcrig
