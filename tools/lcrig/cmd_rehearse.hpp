// SPDX-License-Identifier: Apache-2.0
// The seam to the daemon's App: everything else of the command line does without it.
#pragma once

#include "base/result.hpp"

namespace lcrig {

struct RehearseRequest;
struct RehearseResult;
Result<RehearseResult> rehearse(const RehearseRequest& request);  // daemon/rehearse.hpp

namespace cli {
using RehearseFunction = Result<RehearseResult> (*)(const RehearseRequest&);
}

}  // namespace lcrig
