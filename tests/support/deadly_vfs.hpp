// SPDX-License-Identifier: Apache-2.0
// A process that dies while it writes to its database, for tests that fork.
#pragma once

#include <unistd.h>

#include "storage/forwarding_vfs.hpp"

namespace lcrig {

// Ends the process at the nth write, truncation or sync.
class DeadlyVfs final : public ForwardingVfs {
 public:
  explicit DeadlyVfs(int operations) : ForwardingVfs("lcrig-deadly", true), left_(operations) {}

 protected:
  int write(File& file, const void* data, int bytes, sqlite3_int64 at) override {
    count();
    return ForwardingVfs::write(file, data, bytes, at);
  }
  int truncate(File& file, sqlite3_int64 bytes) override {
    count();
    return ForwardingVfs::truncate(file, bytes);
  }
  int sync(File& file, int flags) override {
    count();
    return ForwardingVfs::sync(file, flags);
  }

 private:
  void count() {
    if (left_-- == 0) ::_exit(kDied);
  }
  int left_;

 public:
  static constexpr int kDied = 9;
};

}  // namespace lcrig
