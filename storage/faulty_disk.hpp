// SPDX-License-Identifier: Apache-2.0
// A disk that fails on command, for rehearsed faults and tests: an SQLite VFS on top of the real
// one. It returns the errors that a real failing disk would return.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/time.hpp"

namespace lcrig {

// Its functions may be called from any thread. Must outlive every connection opened with its name.
class FaultyDisk {
 public:
  FaultyDisk();
  ~FaultyDisk();
  FaultyDisk(const FaultyDisk&) = delete;
  FaultyDisk& operator=(const FaultyDisk&) = delete;
  const std::string& name() const;  // for Database::open

  // Files can no longer grow. As on a real disk, deleting the reserve file (DATABASE.reserve) frees
  // as much room as it took.
  void set_full(bool on);
  // As after the kernel remounted the disk: open files refuse writes, and files open read-only.
  void set_read_only(bool on);
  // Each sync takes longer by `delay`, in real time.
  void set_sync_delay(Duration delay);

  // The nth write, truncation or sync from now on (0: the next one) fails once.
  enum class Failure { io_error, full };
  void fail_operation(std::int64_t n, Failure how);
  bool has_failed() const;  // the failure set by fail_operation happened
  std::int64_t operations() const;

 private:
  class Vfs;
  std::unique_ptr<Vfs> vfs_;
};

// While on, every SQLite allocation in this process fails with SQLITE_NOMEM.
void set_sqlite_memory_short(bool on);

}  // namespace lcrig
