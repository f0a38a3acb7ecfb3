// SPDX-License-Identifier: Apache-2.0
// The database as the only writer of runs opens it: locked, migrated, orphaned runs closed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "storage/database.hpp"

namespace lcrig {

// An exclusive lock on FILE.lock, which holds the owner's process id. The kernel releases it when
// the process ends, however it ends; the lock file stays.
class WriterLock {
 public:
  // busy: another process (or another lock of this one) holds it; the message says who.
  static Result<WriterLock> acquire(const std::string& database_path);
  WriterLock(WriterLock&& other) noexcept;
  WriterLock& operator=(WriterLock&& other) noexcept;
  ~WriterLock();

 private:
  explicit WriterLock(int fd) : fd_(fd) {}
  int fd_ = -1;
};

struct OwnedDatabase {
  WriterLock lock;
  Database db;
  std::vector<std::int64_t> interrupted;  // runs found without an end, now closed
};
Result<OwnedDatabase> open_as_owner(const std::string& path, std::int64_t now_unix_ns,
                                    const std::string& vfs = "");

}  // namespace lcrig
