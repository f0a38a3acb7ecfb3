// SPDX-License-Identifier: Apache-2.0
// A disk that goes wrong on command, for drills and tests: an SQLite VFS over the real one. What it
// does to a write is what the real one would report.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "base/clock.hpp"

namespace lcrig {

// Set from any thread. Outlives every connection that was opened with its name.
class FaultyDisk {
 public:
  FaultyDisk();
  ~FaultyDisk();
  FaultyDisk(const FaultyDisk&) = delete;
  FaultyDisk& operator=(const FaultyDisk&) = delete;
  const std::string& name() const;  // for Database::open

  // No file grows any more. Deleting the reserve file (DATABASE.reserve) makes as much room as it
  // had, as on a real disk.
  void set_full(bool on);
  // As after the kernel remounted it: open files refuse writes, files open only for reading.
  void set_read_only(bool on);
  // Each sync takes so much longer, in real time; 0: none.
  void set_sync_delay(Duration delay);

  // The nth write, truncation or sync from now on (0: the next one) fails, once.
  enum class Failure { io_error, full };
  void fail_operation(std::int64_t n, Failure how);
  bool has_failed() const;  // it was reached
  std::int64_t operations() const;  // so far

 private:
  class Vfs;
  std::unique_ptr<Vfs> vfs_;
};

// Every further allocation of SQLite in this process fails (SQLITE_NOMEM) until it is switched off.
void set_sqlite_memory_short(bool on);

}  // namespace lcrig
