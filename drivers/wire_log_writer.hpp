// SPDX-License-Identifier: Apache-2.0
// Writes wire logs (wire_log.hpp) on a thread of its own, so that a slow, full or missing disk does
// not delay any byte on the wire. The queue is bounded. Entries that do not fit are dropped and
// counted, and both the log and the journal say so. Used by the real rig and by RecordingTransport.
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
  // Refuses an existing path and a link, because the folder may be writable by everybody.
  static int create_exclusively(const std::string& path);

  struct Options {
    std::size_t max_waiting_bytes = std::size_t{8} << 20U;  // bytes; an hour of a quiet rig
    Create create = create_exclusively;
  };
  WireLogWriter() : WireLogWriter(Options()) {}
  explicit WireLogWriter(Options options);
  // Waits for the disk as `finish` does, at most 2 s. Then it abandons a thread that hangs in the
  // disk.
  ~WireLogWriter();
  WireLogWriter(const WireLogWriter&) = delete;
  WireLogWriter& operator=(const WireLogWriter&) = delete;

  // One log, used from one thread; it never waits. When it is destroyed, the rest is written and
  // synced (fsync).
  class File;
  // `whose` names the instrument in the warning when there will be no log.
  std::unique_ptr<File> create(std::string path, std::string whose);

  // Call when a run begins: whatever prevents a log is then reported again, even if it was before.
  void remind();

  // True: everything added so far is on the disk. False: it is not, after this time.
  bool finish(Duration patience);

 private:
  class Told;
  struct Log;
  struct Job;
  struct Queue;
  static void perform(const Job& job, Queue& queue, std::vector<std::shared_ptr<Log>>& open);
  static void work(const std::shared_ptr<Queue>& queue);

  std::shared_ptr<Queue> queue_;  // shared with the files, and with a thread that hangs
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
  std::size_t left_out_ = 0;  // entries dropped since the last one that was queued
  std::size_t all_left_out_ = 0;
};

}  // namespace lcrig
