// SPDX-License-Identifier: Apache-2.0
// A disk that fails on command: an SQLite VFS on top of the real one. It returns the errors of a
// real failing disk. Used by rehearsed faults and tests.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

#include "base/time.hpp"
#include "storage/forwarding_vfs.hpp"

namespace lcrig {

// Its public functions may be called from any thread. `name` is for Database::open.
class FaultyDisk final : public ForwardingVfs {
 public:
  FaultyDisk();

  // Files can no longer grow. As on a real disk, deleting the reserve file (DATABASE.reserve) frees
  // as much room as it took.
  void set_full(bool on);
  // As after the kernel remounted the disk read-only: open files refuse writes, and new ones open
  // read-only.
  void set_read_only(bool on) { read_only_ = on; }
  // Each sync takes longer by `delay`, in real time.
  void set_sync_delay(Duration delay) {
    delay_us_ = std::chrono::duration_cast<std::chrono::microseconds>(delay).count();
  }

  // The nth write, truncation or sync from now on (0: the next one) fails once.
  enum class Failure { io_error, full };
  void fail_operation(std::int64_t n, Failure how);
  bool has_failed() const { return failed_; }  // the failure set by fail_operation happened
  std::int64_t operations() const { return operations_; }

 private:
  bool has_room(std::int64_t bytes);
  int next_operation(int io_error);
  int open(File& file, sqlite3_filename path, int flags, int* out_flags) override;
  int remove(const char* path, int sync) override;
  int write(File& file, const void* data, int bytes, sqlite3_int64 at) override;
  int truncate(File& file, sqlite3_int64 bytes) override;
  int sync(File& file, int flags) override;

  // Set by one thread and read by the writer's thread.
  std::atomic<bool> read_only_ = false, full_ = false, failed_ = false;
  std::atomic<std::int64_t> delay_us_ = 0, operations_ = 0;
  std::atomic<std::int64_t> fail_at_ = -1;  // value of `operations_`; -1: never
  Failure how_ = Failure::io_error;
  std::mutex mutex_;  // guards the members below
  std::string reserve_;  // path; empty until the main database was opened
  std::int64_t reserve_bytes_ = 0;  // its size when the disk became full
  std::int64_t grown_bytes_ = 0;  // growth of all files since then
};

// While on, every SQLite allocation in this process fails with SQLITE_NOMEM.
void set_sqlite_memory_short(bool on);

}  // namespace lcrig
