// SPDX-License-Identifier: Apache-2.0
// Opens the database for the only writer of runs: locks and migrates it, and closes orphaned runs.
// Used by the recorder.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/time.hpp"
#include "storage/database.hpp"
#include "storage/writer_lock.hpp"

namespace lcrig {

struct OwnedDatabase {
  WriterLock lock;
  Database db;
  std::vector<std::int64_t> interrupted;  // runs that had no end and were closed now
};
Result<OwnedDatabase> open_as_owner(const std::string& path, std::int64_t now_unix_ns,
                                    const std::string& vfs = "");

// Sets how long a statement waits for another program's lock.
Result<> wait_for_locks(const Database& db, Duration time);

}  // namespace lcrig
