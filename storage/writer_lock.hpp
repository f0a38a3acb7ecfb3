// SPDX-License-Identifier: Apache-2.0
// Tells who writes a database, and which run is being recorded in it. The daemon holds locks on
// FILE.lock that the kernel releases when it ends, however it ends; everybody else can ask for
// them.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "base/result.hpp"

namespace lcrig {

// FILE`suffix`, beside the file itself when `database_path` is a link to it: there SQLite keeps its
// own companions.
std::string beside_database(const std::string& database_path, const char* suffix);

// The only writer of runs. The lock file holds its process id and stays.
class WriterLock {
 public:
  // busy: another process (or another lock of this one) holds it; the message says who.
  static Result<WriterLock> acquire(const std::string& database_path);
  WriterLock(WriterLock&& other) noexcept;
  WriterLock& operator=(WriterLock&& other) noexcept;
  ~WriterLock();

  // Marks `run` as being recorded. To be called before its row can be seen.
  Result<> begin_run(std::int64_t run);
  void end_run();  // no run is being recorded; to be called after its end can be seen

 private:
  WriterLock(int fd, std::string file) : fd_(fd), file_(std::move(file)) {}
  int fd_ = -1;
  std::string file_;
};

// Ask for the locks of others; they create nothing and keep nobody waiting. Errors: the lock file
// is there but cannot be read.
Result<bool> has_writer(const std::string& database_path);
Result<bool> is_being_recorded(const std::string& database_path, std::int64_t run);

}  // namespace lcrig
