// SPDX-License-Identifier: Apache-2.0
// Tells who writes a database, and which run is being recorded in it. Used by the daemon and by
// every program that lists or checks runs. The writer holds two locks. The kernel releases them
// when the writer ends, however it ends.
//   FILE.writer: its holder is the only writer. Only the owner of the file can open it, so no
//   reader
//     of the database can keep a writer from it.
//   FILE.lock: the sign for readers. Each writer makes it anew and locks it before it gets its
//   name,
//     so no reader can hold a lock on it. It holds the writer's process id and the current run.
#pragma once

#include <cstdint>
#include <string>

#include "base/result.hpp"

namespace lcrig {

// FILE`suffix`, beside the file itself when `database_path` is a link to it, because SQLite keeps
// its own companions there.
std::string beside_database(const std::string& database_path, const char* suffix);

// The lock of the only writer of runs. Both files stay.
class WriterLock {
 public:
  // busy: another process (or another lock of this process) holds it; the message says who.
  static Result<WriterLock> acquire(const std::string& database_path);
  WriterLock(WriterLock&& other) noexcept;
  WriterLock& operator=(WriterLock&& other) noexcept;
  ~WriterLock();

  // Marks `run` as being recorded. Call it before others can see its row.
  Result<> begin_run(std::int64_t run);
  void end_run();  // no run is being recorded; call it after others can see its end

 private:
  explicit WriterLock(int fd) : fd_(fd) {}
  Result<> put_up_sign(const std::string& file);
  Result<> write_sign(std::int64_t run) const;
  int fd_ = -1, sign_ = -1;
  std::string sign_file_;
};

// Read the sign of a writer. They create nothing and keep nobody waiting. Only an exclusive lock
// counts, because a reader of the database cannot take one. Errors: the sign exists but cannot be
// read.
Result<bool> has_writer(const std::string& database_path);
Result<bool> is_being_recorded(const std::string& database_path, std::int64_t run);

}  // namespace lcrig
