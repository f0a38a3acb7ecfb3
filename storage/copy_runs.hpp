// SPDX-License-Identifier: Apache-2.0
// Copies whole runs into another database: their rows, their notes, their tags, and the hash chain
// as it is. They get numbers of the other database and keep their uuids. `lcrig runs copy` uses it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace lcrig {

struct RunCopyOptions {
  std::function<bool()> goes_on;  // asked in between; false ends it. Empty: it goes on
  std::string by;  // who copies
  std::int64_t now_unix_ns = 0;
  std::string vfs;  // of SQLite, for the other database; empty: the operating system's
};

struct CopiedRun {
  std::int64_t from = 0, to = 0;  // its number here and there
  std::string uuid;
  std::int64_t rows = 0;  // that its chain covers
};

// `to` is created when nothing is there. The chains are verified before and after. Errors, after
// each of which `to` is as it was: invalid_request (no such run, a broken or open one, one that is
// there already, a place that is no database of this schema, the database itself), busy (a daemon
// records into `to`), io, aborted. Error::database is `to` when another one would help.
Result<std::vector<CopiedRun>> copy_runs(const std::string& from, std::vector<std::int64_t> runs,
                                         const std::string& to, RunCopyOptions options);

}  // namespace lcrig
