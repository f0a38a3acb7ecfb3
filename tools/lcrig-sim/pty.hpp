// SPDX-License-Identifier: Apache-2.0
// A pseudo-terminal that stands in for a serial port. Used by the ports of lcrig-sim.
#pragma once

#include <string>
#include <utility>

#include "base/result.hpp"

namespace lcrig::sim {

// The pty is in raw mode. This process keeps the device open, too, so that when one client leaves
// the next one finds the same instrument. Closing both sides unplugs it.
class Pty {
 public:
  static Result<Pty> open();
  Pty(Pty&& other) noexcept;
  Pty& operator=(Pty&& other) noexcept;
  ~Pty();

  const std::string& path() const { return path_; }  // "/dev/pts/5"
  // call once; the caller closes it
  int release_master() { return std::exchange(master_, -1); }
  // A serial port loses TIOCEXCL when its last user is gone, even by SIGKILL. This process keeps
  // the device open all the time, so it must remove the mark of a dead client itself.
  void forget_dead_client() const;

 private:
  Pty(int master, int device, std::string path)
      : master_(master), device_(device), path_(std::move(path)) {}
  int master_ = -1, device_ = -1;
  std::string path_;
};

}  // namespace lcrig::sim
