// SPDX-License-Identifier: Apache-2.0
// A pseudo-terminal that plays the part of a serial port.
#pragma once

#include <string>

#include "base/result.hpp"

namespace lcrig::sim {

// Raw mode. The device stays open on this side, so that a client that leaves is no unplug: whoever
// opens it next finds the same instrument. Closing both sides is the unplug.
class Pty {
 public:
  static Result<Pty> open();
  Pty(Pty&& other) noexcept;
  Pty& operator=(Pty&& other) noexcept;
  ~Pty();

  const std::string& path() const { return path_; }  // "/dev/pts/5"
  int release_master();  // once; the caller closes it
  // A serial port forgets TIOCEXCL when its last user is gone, even by SIGKILL. This device always
  // has a user (us), so the mark of a dead client is taken off here.
  void forget_dead_client() const;

 private:
  Pty(int master, int device, std::string path)
      : master_(master), device_(device), path_(std::move(path)) {}
  int master_ = -1, device_ = -1;
  std::string path_;
};

}  // namespace lcrig::sim
