// SPDX-License-Identifier: Apache-2.0
// Copies a whole database, also while the daemon records into it: taken from one state, checked,
// and only then given its name. It never makes the recorder wait. `lcrig backup` and `lcrig
// restore` use it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace lcrig {

struct CopyOptions {
  // Asked in between; false ends it. Empty: it goes on.
  std::function<bool()> goes_on;
  bool check_original = false;  // its pages, before they are copied
  std::string vfs;  // of SQLite, for the copy; empty: the operating system's
};

struct BrokenRun {
  std::int64_t run = 0;
  std::string finding;
};

struct CopyReport {
  std::int64_t bytes = 0, runs = 0, rows = 0;
  std::vector<std::int64_t> without_end;  // they went on at that instant, or were cut off
  std::vector<BrokenRun> broken;  // not as they were recorded; the same in the original
};

// Errors, after each of which nothing is left behind: invalid_request (`to` is there already, or
// cannot become a database), io (no room, a damaged original, a copy unlike it), aborted.
Result<CopyReport> copy_database(const std::string& from, const std::string& to,
                                 CopyOptions options = {});

// Bytes left free on a disk that the recorder shares: an hour of the fastest rig's rows, and its
// log.
constexpr std::uintmax_t kLeftToRecorder = 64U << 20U;
// This thread gives way to the recorder, at the processor and at the disk.
void give_way();
// `to` is none of the files that SQLite and lcrigd keep beside the database `from`.
Result<> require_no_companion(const std::string& from, const std::string& to);

}  // namespace lcrig
