// SPDX-License-Identifier: Apache-2.0
#include "storage/faulty_disk.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

namespace lcrig {

namespace {

std::int64_t size_of(const std::string& path) {
  struct stat found{};
  return ::stat(path.c_str(), &found) == 0 ? found.st_size : 0;
}

}  // namespace

FaultyDisk::FaultyDisk()
    : ForwardingVfs(fmt::format("lcrig-faulty-{}", static_cast<const void*>(this))) {}

void FaultyDisk::set_full(bool on) {
  const std::lock_guard lock(mutex_);
  reserve_bytes_ = size_of(reserve_);
  grown_bytes_ = 0;
  full_ = on;
}

void FaultyDisk::fail_operation(std::int64_t n, Failure how) {
  how_ = how;
  failed_ = false;
  fail_at_ = operations_ + n;
}

bool FaultyDisk::has_room(std::int64_t bytes) {
  const std::lock_guard lock(mutex_);
  const std::int64_t freed = reserve_bytes_ - size_of(reserve_);
  if (grown_bytes_ + bytes > freed) return false;
  grown_bytes_ += bytes;
  return true;
}

// SQLITE_OK, or the error that this write, truncation or sync returns.
int FaultyDisk::next_operation(int io_error) {
  if (operations_++ == fail_at_) {
    failed_ = true;
    return how_ == Failure::full ? SQLITE_FULL : io_error;
  }
  return read_only_ ? io_error : SQLITE_OK;
}

int FaultyDisk::open(File& file, sqlite3_filename path, int flags, int* out_flags) {
  if (path != nullptr && (flags & SQLITE_OPEN_MAIN_DB) != 0) {
    const std::lock_guard lock(mutex_);
    reserve_ = std::string(path) + ".reserve";
  }
  if (read_only_ && (flags & SQLITE_OPEN_READWRITE) != 0) {
    flags &= ~(SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_EXCLUSIVE);
    flags |= SQLITE_OPEN_READONLY;
  }
  return ForwardingVfs::open(file, path, flags, out_flags);
}

int FaultyDisk::remove(const char* path, int sync) {
  return read_only_ ? SQLITE_IOERR_DELETE : ForwardingVfs::remove(path, sync);
}

int FaultyDisk::write(File& file, const void* data, int bytes, sqlite3_int64 at) {
  if (const int rc = next_operation(SQLITE_IOERR_WRITE); rc != SQLITE_OK) return rc;
  if (full_) {
    sqlite3_int64 size = 0;
    const int rc = file.real()->pMethods->xFileSize(file.real(), &size);
    if (rc != SQLITE_OK) return rc;
    if (at + bytes > size && !has_room(at + bytes - size)) return SQLITE_FULL;
  }
  return ForwardingVfs::write(file, data, bytes, at);
}

int FaultyDisk::truncate(File& file, sqlite3_int64 bytes) {
  const int rc = next_operation(SQLITE_IOERR_TRUNCATE);
  return rc != SQLITE_OK ? rc : ForwardingVfs::truncate(file, bytes);
}

int FaultyDisk::sync(File& file, int flags) {
  if (const int rc = next_operation(SQLITE_IOERR_FSYNC); rc != SQLITE_OK) return rc;
  const std::int64_t us = delay_us_;
  if (us > 0) real().xSleep(&real(), static_cast<int>(us));
  return ForwardingVfs::sync(file, flags);
}

void set_sqlite_memory_short(bool on) {
  // With a hard limit below the memory in use, SQLite refuses every further allocation; 0 means no
  // limit.
  sqlite3_hard_heap_limit64(on ? 1 : 0);
  if (!on) sqlite3_soft_heap_limit64(0);
}

}  // namespace lcrig
