// SPDX-License-Identifier: Apache-2.0
// Starts one of our programs as a process, and talks to it. Every wait is for a kernel event and
// has a deadline. Used by all end-to-end tests.
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

// Waits until `fd` can be read or its other end is closed. False on timeout.
bool readable(int fd, Timeout timeout);

// Reads lines from a descriptor and owns it.
class LineReader {
 public:
  explicit LineReader(int fd) : fd_(fd) {}
  LineReader(LineReader&& other) noexcept;
  ~LineReader();
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;
  // nullopt: end of file, or no line in time.
  std::optional<std::string> next(Timeout timeout);
  std::string rest(Timeout timeout);  // to the end of file
  int fd() const { return fd_; }

 private:
  bool fill(Timeout timeout);
  int fd_;
  std::string buffer_;
};

// environment(): that of this process without LCRIG_*, plus `variables`. pointers(): for execve.
std::vector<std::string> environment(const std::map<std::string, std::string>& variables);
std::vector<char*> pointers(std::vector<std::string>& texts);

// The owner of a process. Only root can start a process of another person.
struct Person {
  uid_t user = 0;
  gid_t group = 0;
};

class Child {
 public:
  using Variables = std::map<std::string, std::string>;
  // the latter: without root's power to ignore permission bits
  enum class Rights { as_we_are, those_of_the_files };
  // Standard error goes to the file `log`. The child dies with this process.
  Child(const std::vector<std::string>& command, const std::string& log,
        const Variables& variables = {}, Rights rights = Rights::as_we_are,
        const Person* person = nullptr);
  ~Child();  // kills it if it still runs
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  pid_t pid() const { return pid_; }
  int exit_fd() const { return exit_fd_; }  // readable when the process has ended
  void signal(int number) const;
  // Exit code, or 128 + the signal that ended it. nullopt: it still runs.
  std::optional<int> wait(Timeout timeout);
  LineReader& out() { return *out_; }
  std::string log() const;  // standard error so far

 private:
  pid_t pid_ = -1;
  int exit_fd_ = -1;
  std::optional<int> status_;
  std::optional<LineReader> out_;
  std::string log_;
};

// A line-based client of a Unix stream socket: the daemon's, or the simulator's back door.
class LineClient {
 public:
  explicit LineClient(const std::string& path);
  void send(std::string_view line) const;
  std::optional<std::string> next(Timeout timeout) { return reader_.next(timeout); }

 private:
  LineReader reader_;
};

}  // namespace lcrig::e2e
