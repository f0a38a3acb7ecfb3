// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/child.hpp"

#include <fcntl.h>
#include <grp.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "base/clock.hpp"
#include "tests/support/without_rights.hpp"

namespace lcrig::e2e {

namespace {

[[noreturn]] void throw_errno(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

// Runs in the child between fork and exec, so it makes only calls that are safe there.
[[noreturn]] void become(char* const* argv, char* const* envp, int out, int log) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int nothing = ::open("/dev/null", O_RDONLY);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(out, STDOUT_FILENO);
  ::dup2(log, STDERR_FILENO);
  ::execve(argv[0], argv, envp);
  ::_exit(127);
}

// Also runs between fork and exec.
bool turn_into(const Person& person) {
  ::umask(0027);  // as in the service
  return ::setgroups(0, nullptr) == 0 && ::setgid(person.group) == 0 && ::setuid(person.user) == 0;
}

int connect_to(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) throw std::runtime_error("long path: " + path);
  std::memcpy(address.sun_path, path.data(), path.size());
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw_errno("connect " + path);
  }
  return fd;
}

}  // namespace

std::vector<std::string> environment(const Child::Variables& variables) {
  std::vector<std::string> out;
  for (char** e = environ; *e != nullptr; ++e) {
    const std::string_view entry = *e;
    const std::string name(entry.substr(0, entry.find('=')));
    if (!name.starts_with("LCRIG_") && !variables.contains(name)) out.emplace_back(entry);
  }
  for (const auto& [name, value] : variables) out.push_back(name + "=" + value);
  return out;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> out;
  for (auto& t : texts) out.push_back(t.data());
  out.push_back(nullptr);
  return out;
}

bool readable(int fd, Timeout timeout) {
  const RealClock clock;
  const MonoTime limit = clock.now() + timeout;
  for (;;) {
    const auto left = std::chrono::duration_cast<Timeout>(limit - clock.now());
    pollfd wanted{fd, POLLIN, 0};
    const int n = ::poll(&wanted, 1, static_cast<int>(std::max<Timeout::rep>(0, left.count())));
    if (n >= 0) return n > 0;
    if (errno != EINTR) throw_errno("poll");
  }
}

LineReader::LineReader(LineReader&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), buffer_(std::move(other.buffer_)) {}

LineReader::~LineReader() {
  if (fd_ >= 0) ::close(fd_);
}

bool LineReader::fill(Timeout timeout) {
  std::array<char, 4096> chunk;
  if (!readable(fd_, timeout)) return false;
  const ssize_t n = ::read(fd_, chunk.data(), chunk.size());
  if (n <= 0) return false;
  buffer_.append(chunk.data(), static_cast<std::size_t>(n));
  return true;
}

std::optional<std::string> LineReader::next(Timeout timeout) {
  const RealClock clock;
  const MonoTime limit = clock.now() + timeout;
  for (;;) {
    if (const auto end = buffer_.find('\n'); end != std::string::npos) {
      std::string line = buffer_.substr(0, end);
      buffer_.erase(0, end + 1);
      return line;
    }
    const auto left = std::chrono::duration_cast<Timeout>(limit - clock.now());
    if (left < 0ms || !fill(left)) return std::nullopt;
  }
}

std::string LineReader::rest(Timeout timeout) {
  while (fill(timeout)) {
  }
  return std::exchange(buffer_, {});
}

Child::Child(const std::vector<std::string>& command, const std::string& log,
             const Variables& variables, Rights rights, const Person* person)
    : log_(log) {
  auto words = command;
  auto names = environment(variables);
  const auto argv = pointers(words);
  const auto envp = pointers(names);
  int out[2];
  if (::pipe2(out, O_CLOEXEC) != 0) throw_errno("pipe");
  const int err = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (err < 0) throw_errno(log);
  pid_ = ::fork();
  if (pid_ == 0 && rights == Rights::those_of_the_files) give_up_file_rights_at_exec();
  if (pid_ == 0 && person != nullptr && !turn_into(*person)) ::_exit(126);
  if (pid_ == 0) become(argv.data(), envp.data(), out[1], err);
  ::close(out[1]);
  ::close(err);
  out_.emplace(out[0]);
  if (pid_ < 0) throw_errno("fork");
  exit_fd_ = static_cast<int>(::syscall(SYS_pidfd_open, pid_, 0));
  if (exit_fd_ < 0) throw_errno("pidfd_open");
}

Child::~Child() {
  if (!status_) {
    signal(SIGKILL);
    wait(10s);
  }
  ::close(exit_fd_);
}

void Child::signal(int number) const {
  if (!status_) ::kill(pid_, number);
}

std::optional<int> Child::wait(Timeout timeout) {
  if (status_) return status_;
  if (!readable(exit_fd_, timeout)) return std::nullopt;
  int status = 0;
  if (::waitpid(pid_, &status, 0) != pid_) throw_errno("waitpid");
  status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return status_;
}

std::string Child::log() const {
  std::ifstream file(log_);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

LineClient::LineClient(const std::string& path) : reader_(connect_to(path)) {}

void LineClient::send(std::string_view line) const {
  const std::string bytes = std::string(line) + "\n";
  const ssize_t n = ::send(reader_.fd(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (n != static_cast<ssize_t>(bytes.size())) throw_errno("send");
}

}  // namespace lcrig::e2e
