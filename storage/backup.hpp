// SPDX-License-Identifier: Apache-2.0
// Copies a whole database, also while the daemon records into it. The copy is taken from one state,
// checked, and only then given its name. The recorder never waits for it. Used by `lcrig backup`
// and `lcrig restore`.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace lcrig {

struct CopyOptions {
  // Called between steps; false stops the copy. Empty: it is never stopped.
  std::function<bool()> goes_on;
  bool check_original = false;  // check the original's pages before they are copied
  std::string vfs;  // SQLite's VFS for the copy; empty: the operating system's
};

struct BrokenRun {
  std::int64_t run = 0;
  std::string finding;
};

struct CopyReport {
  std::int64_t bytes = 0, runs = 0, rows = 0;
  std::vector<std::int64_t> without_end;  // still being recorded at that instant, or cut off
  std::vector<BrokenRun> broken;  // differ from what was recorded, in the original as well
};

// Errors: invalid_request (`to` exists, or cannot become a database), io (no room, a damaged
// original, a copy that differs from it), aborted. Nothing is left behind after an error.
Result<CopyReport> copy_database(const std::string& from, const std::string& to,
                                 CopyOptions options = {});

// Bytes to leave free on a disk that the recorder shares: an hour of the fastest rig's rows, and
// their log.
constexpr std::uintmax_t kLeftToRecorder = 64U << 20U;
// Lowers the priority of this thread below the recorder's, for processor and disk.
void give_way();
// Refuses `to` when SQLite or lcrigd keeps that file beside the database `from`.
Result<> require_no_companion(const std::string& from, const std::string& to);

}  // namespace lcrig
