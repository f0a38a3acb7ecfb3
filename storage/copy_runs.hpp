// SPDX-License-Identifier: Apache-2.0
// Copies whole runs into another database: their rows, notes and tags, and their hash chain
// unchanged. They get new numbers there and keep their uuids. Used by `lcrig runs copy`.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace lcrig {

struct RunCopyOptions {
  std::function<bool()> goes_on;  // called between steps; false stops the copy. Empty: it is never
                                  // stopped
  std::string by;  // who copies
  std::int64_t now_unix_ns = 0;
  std::string vfs;  // SQLite's VFS for the other database; empty: the operating system's
};

struct CopiedRun {
  std::int64_t from = 0, to = 0;  // its number here and there
  std::string uuid;
  std::int64_t rows = 0;  // rows that its chain covers
};

// Creates `to` if it does not exist. Verifies the chains before and after. Errors: invalid_request
// (no such run, a broken or open one, one that `to` already has, a `to` that is no database of this
// schema or is `from` itself), busy (a daemon records into `to`), io, aborted. After an error `to`
// is as it was. Error::database is `to` when choosing another one would help.
Result<std::vector<CopiedRun>> copy_runs(const std::string& from, std::vector<std::int64_t> runs,
                                         const std::string& to, RunCopyOptions options);

}  // namespace lcrig
