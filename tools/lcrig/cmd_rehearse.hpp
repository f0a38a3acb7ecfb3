// SPDX-License-Identifier: Apache-2.0
// The connection to the daemon's App (daemon/rehearse.hpp). Only main.cpp names the real functions.
// The rest of the command line is built without the daemon.
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
