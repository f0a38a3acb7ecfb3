// SPDX-License-Identifier: Apache-2.0
// Runs `lcrig rehearse --batch`: a whole day of runs on the simulated bench. cmd_rehearse.cpp calls
// it.
#pragma once

#include "daemon/rehearse_batch.hpp"
#include "tools/lcrig/batch_request.hpp"

namespace lcrig::cli {

// `request` has everything except the batch. Failure: in the daemon's words.
Outcome<ExitCode> rehearse_table(Context& context, const BatchRequest& batch,
                                 RehearseBatchRequest request, const BatchOptions& options);

}  // namespace lcrig::cli
