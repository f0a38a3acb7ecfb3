// SPDX-License-Identifier: Apache-2.0
#include "storage/faulty_disk.hpp"

#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <atomic>
#include <mutex>

#include "storage/forwarding_vfs.hpp"

namespace lcrig {

namespace {

constexpr std::int64_t kNever = -1;

}  // namespace

// The state is set by one thread and read by the writer's thread.
class FaultyDisk::Vfs final : public ForwardingVfs {
 public:
  using ForwardingVfs::ForwardingVfs;

  std::atomic<bool> read_only = false;
  std::atomic<std::int64_t> delay_us = 0;
  std::atomic<std::int64_t> operations = 0;
  std::atomic<std::int64_t> fail_at = kNever;  // value of `operations`
  std::atomic<bool> failed = false;
  Failure how = Failure::io_error;

  void become_full(bool on) {
    const std::lock_guard lock(mutex_);
    reserve_bytes_ = size_of(reserve_);
    grown_bytes_ = 0;
    full_ = on;
  }

 private:
  static std::int64_t size_of(const std::string& path) {
    struct stat found{};
    return ::stat(path.c_str(), &found) == 0 ? found.st_size : 0;
  }

  bool has_room(std::int64_t bytes) {
    const std::lock_guard lock(mutex_);
    const std::int64_t freed = reserve_bytes_ - size_of(reserve_);
    if (grown_bytes_ + bytes > freed) return false;
    grown_bytes_ += bytes;
    return true;
  }

  // SQLITE_OK, or the error for this write, truncation or sync.
  int next_operation(int io_error) {
    const std::int64_t n = operations++;
    if (n == fail_at) {
      failed = true;
      return how == Failure::full ? SQLITE_FULL : io_error;
    }
    return read_only ? io_error : SQLITE_OK;
  }

  int open(File& file, sqlite3_filename path, int flags, int* out_flags) override {
    if (path != nullptr && (flags & SQLITE_OPEN_MAIN_DB) != 0) {
      const std::lock_guard lock(mutex_);
      reserve_ = std::string(path) + ".reserve";
    }
    if (read_only && (flags & SQLITE_OPEN_READWRITE) != 0) {
      flags &= ~(SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_EXCLUSIVE);
      flags |= SQLITE_OPEN_READONLY;
    }
    return ForwardingVfs::open(file, path, flags, out_flags);
  }

  int remove(const char* path, int sync) override {
    return read_only ? SQLITE_IOERR_DELETE : ForwardingVfs::remove(path, sync);
  }

  int write(File& file, const void* data, int bytes, sqlite3_int64 at) override {
    if (const int rc = next_operation(SQLITE_IOERR_WRITE); rc != SQLITE_OK) return rc;
    if (full_) {
      sqlite3_int64 size = 0;
      const int rc = file.real()->pMethods->xFileSize(file.real(), &size);
      if (rc != SQLITE_OK) return rc;
      if (at + bytes > size && !has_room(at + bytes - size)) return SQLITE_FULL;
    }
    return ForwardingVfs::write(file, data, bytes, at);
  }

  int truncate(File& file, sqlite3_int64 bytes) override {
    const int rc = next_operation(SQLITE_IOERR_TRUNCATE);
    return rc != SQLITE_OK ? rc : ForwardingVfs::truncate(file, bytes);
  }

  int sync(File& file, int flags) override {
    if (const int rc = next_operation(SQLITE_IOERR_FSYNC); rc != SQLITE_OK) return rc;
    const std::int64_t us = delay_us;
    if (us > 0) real().xSleep(&real(), static_cast<int>(us));
    return ForwardingVfs::sync(file, flags);
  }

  std::atomic<bool> full_ = false;
  std::mutex mutex_;  // guards the members below
  std::string reserve_;  // path; empty until the main database was opened
  std::int64_t reserve_bytes_ = 0;  // when the disk became full
  std::int64_t grown_bytes_ = 0;  // since then
};

FaultyDisk::FaultyDisk()
    : vfs_(std::make_unique<Vfs>(fmt::format("lcrig-faulty-{}", static_cast<const void*>(this)))) {}

FaultyDisk::~FaultyDisk() = default;

const std::string& FaultyDisk::name() const {
  return vfs_->name();
}

void FaultyDisk::set_full(bool on) {
  vfs_->become_full(on);
}
void FaultyDisk::set_read_only(bool on) {
  vfs_->read_only = on;
}
void FaultyDisk::set_sync_delay(Duration delay) {
  vfs_->delay_us = std::chrono::duration_cast<std::chrono::microseconds>(delay).count();
}

void FaultyDisk::fail_operation(std::int64_t n, Failure how) {
  vfs_->how = how;
  vfs_->failed = false;
  vfs_->fail_at = vfs_->operations + n;
}
bool FaultyDisk::has_failed() const {
  return vfs_->failed;
}
std::int64_t FaultyDisk::operations() const {
  return vfs_->operations;
}

void set_sqlite_memory_short(bool on) {
  // With a hard limit below the memory in use, SQLite refuses every further allocation; 0 means no
  // limit.
  sqlite3_hard_heap_limit64(on ? 1 : 0);
  if (!on) sqlite3_soft_heap_limit64(0);
}

}  // namespace lcrig
