// SPDX-License-Identifier: Apache-2.0
// Reads an interrupted run from the database and prepares it, so that a new one can continue it
// (decision 6). App uses it for `run.resume` and for the queue.
#pragma once

#include <vector>

#include "daemon/control/messages.hpp"
#include "daemon/session.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

// Protocol, parameters and specimen of the run, and the step where it stopped. Errors:
// invalid_request (no such run, not interrupted, continued already, was in `finally`).
Result<PreparedRun> prepare_continuation(const Database& db, std::int64_t run);

// Whether frame and specimen are those that were there before this process: a simulated bench goes
// with the daemon.
enum class RigBefore { still_there, gone };

// The runs that can be continued and were cut off since any other run began: after that the rig,
// and perhaps the specimen, are no longer as they were left. Of a rig that is gone, those that had
// not used its frame yet. Oldest first.
Result<std::vector<ResumableRun>> find_resumable(const Database& db, RigBefore rig);

}  // namespace lcrig
