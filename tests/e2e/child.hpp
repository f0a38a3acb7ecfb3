// SPDX-License-Identifier: Apache-2.0
// A program of ours as a process of its own. Every wait is for an event of the kernel, with a
// deadline.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lcrig::e2e {

using namespace std::chrono_literals;
using Timeout = std::chrono::milliseconds;

// Waits until `fd` can be read (or its other end is gone). False: not in time.
bool readable(int fd, Timeout timeout);

// Lines from a descriptor, which it owns.
class LineReader {
 public:
  explicit LineReader(int fd) : fd_(fd) {}
  LineReader(LineReader&& other) noexcept;
  ~LineReader();
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;
  // nullopt: end of file, or not in time.
  std::optional<std::string> next(Timeout timeout);
  std::string rest(Timeout timeout);  // to the end of file
  int fd() const { return fd_; }

 private:
  bool fill(Timeout timeout);
  int fd_;
  std::string buffer_;
};

// This process's environment without LCRIG_*, and with `variables`; and as execve takes it.
std::vector<std::string> environment(const std::map<std::string, std::string>& variables);
std::vector<char*> pointers(std::vector<std::string>& texts);

class Child {
 public:
  using Variables = std::map<std::string, std::string>;
  enum class Rights { as_we_are, those_of_the_files };  // the latter: not root's beyond the bits
  // Its standard error goes to the file `log`. It dies with this process.
  Child(const std::vector<std::string>& command, const std::string& log,
        const Variables& variables = {}, Rights rights = Rights::as_we_are);
  ~Child();  // kills it if it still runs
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  pid_t pid() const { return pid_; }
  int exit_fd() const { return exit_fd_; }  // readable when the process has ended
  void signal(int number) const;
  // Exit code, or 128 + the signal that ended it. nullopt: it still runs.
  std::optional<int> wait(Timeout timeout);
  LineReader& out() { return *out_; }
  std::string log() const;  // what it wrote to standard error so far

 private:
  pid_t pid_ = -1;
  int exit_fd_ = -1;
  std::optional<int> status_;
  std::optional<LineReader> out_;
  std::string log_;
};

// A client of a Unix stream socket that speaks lines: the daemon's, and the simulator's back door.
class LineClient {
 public:
  explicit LineClient(const std::string& path);
  void send(std::string_view line) const;
  std::optional<std::string> next(Timeout timeout) { return reader_.next(timeout); }

 private:
  LineReader reader_;
};

}  // namespace lcrig::e2e
