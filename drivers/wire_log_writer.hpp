// SPDX-License-Identifier: Apache-2.0
// Writes wire logs (wire_log.hpp) on a thread of its own: a disk that is slow, full or gone keeps
// no byte from the wire. The queue is bounded; what it cannot take is left out, counted, and told
// in the log and in the journal.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/time.hpp"

namespace lcrig {

class WireLogWriter {
 public:
  // Returns a descriptor for writing, or -1 with errno.
  using Create = int (*)(const std::string& path);
  // Refuses a path that exists, and a link: the folder may be one that everybody can write to.
  static int create_exclusively(const std::string& path);

  struct Options {
    std::size_t max_waiting_bytes = std::size_t{8} << 20U;  // an hour of a quiet rig
    Create create = create_exclusively;
  };
  WireLogWriter() : WireLogWriter(Options()) {}
  explicit WireLogWriter(Options options);
  // Waits for the disk as `finish` does, at most 2 s. A thread that hangs in it stays behind.
  ~WireLogWriter();
  WireLogWriter(const WireLogWriter&) = delete;
  WireLogWriter& operator=(const WireLogWriter&) = delete;

  // One log, used from one thread, never waiting. It ends with its last word on the disk (fsync).
  class File;
  // `whose` names the instrument in the warning when there will be no log.
  std::unique_ptr<File> create(std::string path, std::string whose);

  // A run begins: what keeps a log from being written is told once more, even if it was told
  // before.
  void remind();

  // True: what was added until now is on the disk. False: it is not after this time.
  bool finish(Duration patience);

 private:
  class Told;
  struct Log;
  struct Job;
  struct Queue;
  static void perform(const Job& job, Queue& queue, std::vector<std::shared_ptr<Log>>& open);
  static void work(const std::shared_ptr<Queue>& queue);

  std::shared_ptr<Queue> queue_;  // shared with the files and with a thread that hangs
  std::thread thread_;
};

class WireLogWriter::File {
 public:
  File(std::shared_ptr<Queue> queue, std::shared_ptr<Log> log);
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  void add(std::string_view text);

 private:
  std::string remark() const;

  std::shared_ptr<Queue> queue_;
  std::shared_ptr<Log> log_;
  std::size_t left_out_ = 0;  // entries since the last one that the queue took
  std::size_t all_left_out_ = 0;
};

}  // namespace lcrig
