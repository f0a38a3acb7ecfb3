// SPDX-License-Identifier: Apache-2.0
// Runs a program on a terminal of its own (a pty) and plays the person in front of it. Used by
// terminal_test.cpp.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/e2e/child.hpp"

namespace lcrig::e2e {

class Terminal {
 public:
  Terminal(const std::vector<std::string>& command, const Child::Variables& variables);
  ~Terminal();  // kills it if it still runs
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  void type(std::string_view keys) const;
  // Waits until this text has arrived since the last call. False on timeout.
  bool shows(std::string_view text, Timeout timeout = 15s);
  // Everything the program has sent so far, including escape codes.
  const std::string& received() const { return received_; }
  int wait(Timeout timeout);  // exit code, or 128 + signal; -1: it still runs

 private:
  bool fill(Timeout timeout);
  pid_t pid_ = -1;
  int fd_ = -1;
  int status_ = -1;
  std::string received_;
  std::size_t seen_ = 0;
};

}  // namespace lcrig::e2e
