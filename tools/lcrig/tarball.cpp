// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/tarball.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "base/text.hpp"

namespace lcrig::cli {

namespace {

// Standard output goes to `to`, standard error to `said`.
int spawn_into(const std::vector<std::string>& words, int to, int said, pid_t& pid) {
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  // The function takes `char*` but does not change the text.
  for (const auto& word : words) argv.push_back(const_cast<char*>(word.c_str()));  // NOLINT
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, to, STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, said, STDERR_FILENO);
  const int error = ::posix_spawnp(&pid, argv.front(), &actions, nullptr, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  return error;
}

std::string read_all(int fd) {
  std::string out;
  std::array<char, 1024> buffer{};
  for (;;) {
    const ssize_t n = ::read(fd, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return out;
    out.append(buffer.data(), static_cast<std::size_t>(n));
  }
}

int wait_for(pid_t pid) {
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0) {
    if (errno != EINTR) return -1;
  }
  return status;
}

}  // namespace

Outcome<void> pack_folder(const std::filesystem::path& parent, const std::string& name, int to) {
  std::array<int, 2> said{};
  if (::pipe2(said.data(), O_CLOEXEC) != 0) {
    return Failure(kFailed, fmt::format("a pipe: {}", std::strerror(errno)), "");
  }
  pid_t pid = 0;
  const int error = spawn_into({"tar", "--create", "--gzip", "--file=-", "--owner=root:0",
                                "--group=root:0", "--directory=" + parent.string(), "--", name},
                               to, said[1], pid);
  ::close(said[1]);
  const std::string words = error == 0 ? read_all(said[0]) : "";
  ::close(said[0]);
  if (error != 0) {
    return Failure(kFailed, fmt::format("tar cannot be started: {}", std::strerror(error)),
                   "sudo apt install tar gzip");
  }
  if (wait_for(pid) == 0) return {};
  return Failure(kFailed,
                 printable(words.empty() ? "tar failed" : words.substr(0, words.find('\n'))),
                 "df -h; free some space, or name a file on another disk");
}

}  // namespace lcrig::cli
