// SPDX-License-Identifier: Apache-2.0
// Reads an interrupted run from the database and prepares a new run that continues it (decision 6).
// App uses it for `run.resume` and for the queue.
#pragma once

#include <cstdint>
#include <vector>

#include "base/result.hpp"
#include "daemon/control/messages.hpp"

namespace lcrig {

class Database;
struct PreparedRun;

// Protocol, parameters and specimen of the run, and the step where it stopped. Errors:
// invalid_request (no such run, not interrupted, continued already, was in `finally`).
Result<PreparedRun> prepare_continuation(const Database& db, std::int64_t run);

// Whether frame and specimen are still those of before this process. A simulated bench vanishes
// with its daemon.
enum class RigBefore { still_there, gone };

// The runs that can be continued and that were cut off after the last other run began. A later run
// would have changed the rig and perhaps the specimen. If the rig is gone, only runs that had not
// used its frame yet. Oldest first.
Result<std::vector<ResumableRun>> find_resumable(const Database& db, RigBefore rig);

}  // namespace lcrig
