// SPDX-License-Identifier: Apache-2.0
// Tells who writes a database, and which run is being recorded in it. The writer holds two locks,
// which the kernel releases when it ends, however it ends.
//   FILE.writer: who holds it is the only writer. Nobody but the owner of the file can open it, so
//     no reader of the database can keep a writer from it.
//   FILE.lock: the sign for readers. It is made anew by each writer and locked before it gets its
//     name, so no reader can hold a lock on it. It holds the writer's process id and the run that
//     goes on.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "base/result.hpp"

namespace lcrig {

// FILE`suffix`, beside the file itself when `database_path` is a link to it: there SQLite keeps its
// own companions.
std::string beside_database(const std::string& database_path, const char* suffix);

// The only writer of runs. Both files stay.
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
  explicit WriterLock(int fd) : fd_(fd) {}
  Result<> put_up_sign(const std::string& file);
  Result<> write_sign(std::int64_t run) const;
  int fd_ = -1, sign_ = -1;
  std::string sign_file_;
};

// Look at the sign of others; they create nothing and keep nobody waiting. Only an exclusive lock
// counts, which a reader of the database cannot take. Errors: the sign is there but cannot be read.
Result<bool> has_writer(const std::string& database_path);
Result<bool> is_being_recorded(const std::string& database_path, std::int64_t run);

}  // namespace lcrig
