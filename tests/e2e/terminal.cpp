// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/terminal.hpp"

#include <pty.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

#include "base/clock.hpp"

namespace lcrig::e2e {

Terminal::Terminal(const std::vector<std::string>& command, const Child::Variables& variables) {
  auto words = command;
  auto names = environment(variables);
  const auto argv = pointers(words);
  const auto envp = pointers(names);
  winsize size{};
  size.ws_col = 100;
  size.ws_row = 30;
  pid_ = ::forkpty(&fd_, nullptr, nullptr, &size);
  if (pid_ < 0) throw std::runtime_error("forkpty");
  if (pid_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::execve(argv[0], argv.data(), envp.data());
    ::_exit(127);
  }
}

Terminal::~Terminal() {
  if (status_ < 0) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  ::close(fd_);
}

void Terminal::type(std::string_view keys) const {
  if (::write(fd_, keys.data(), keys.size()) < 0) throw std::runtime_error("type");
}

bool Terminal::fill(Timeout timeout) {
  std::array<char, 4096> chunk;
  if (!readable(fd_, timeout)) return false;
  const ssize_t n = ::read(fd_, chunk.data(), chunk.size());
  if (n <= 0) return false;  // EIO: the program has closed its side
  received_.append(chunk.data(), static_cast<std::size_t>(n));
  return true;
}

bool Terminal::shows(std::string_view text, Timeout timeout) {
  const RealClock clock;
  const MonoTime limit = clock.now() + timeout;
  for (;;) {
    if (const auto at = received_.find(text, seen_); at != std::string::npos) {
      seen_ = at + text.size();
      return true;
    }
    const auto left = std::chrono::duration_cast<Timeout>(limit - clock.now());
    if (left <= 0ms || !fill(left)) return false;
  }
}

int Terminal::wait(Timeout timeout) {
  const RealClock clock;
  const MonoTime limit = clock.now() + timeout;
  // Reads to the end of the output, because a program does not end while its terminal is full.
  while (clock.now() < limit && fill(std::chrono::duration_cast<Timeout>(limit - clock.now()))) {
  }
  int status = 0;
  if (clock.now() >= limit || ::waitpid(pid_, &status, 0) != pid_) return -1;
  status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return status_;
}

}  // namespace lcrig::e2e
