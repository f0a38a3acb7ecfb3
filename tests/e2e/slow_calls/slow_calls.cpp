// SPDX-License-Identifier: Apache-2.0
// Preloaded into a program (LD_PRELOAD) to make the surroundings slow. Writes to wire logs,
// look-ups of users, looks at device nodes, the opening of ports (their lock) and their closing
// take SLOW_WIRE_LOG_MS, SLOW_USERS_MS, SLOW_NODES_MS, SLOW_PORTS_MS and SLOW_CLOSES_MS, as on a
// slow disk, with a directory service or behind a busy hub. Used by slow_surroundings_test.cpp.
#include <dlfcn.h>
#include <limits.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/uio.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <thread>

namespace {

void wait_as_told(const char* variable) {
  const char* ms = std::getenv(variable);
  if (ms != nullptr) std::this_thread::sleep_for(std::chrono::milliseconds(std::atoi(ms)));
}

std::string path_of(int fd) {
  char link[32], path[PATH_MAX];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t length = ::readlink(link, path, sizeof path);
  return length > 0 ? std::string(path, static_cast<std::size_t>(length)) : std::string();
}

bool is_wire_log(int fd) {
  return path_of(fd).ends_with(".wire");
}

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* bytes, std::size_t size) {
  static const auto next = real<ssize_t(int, const void*, std::size_t)>("write");
  if (is_wire_log(fd)) wait_as_told("SLOW_WIRE_LOG_MS");
  return next(fd, bytes, size);
}

ssize_t writev(int fd, const iovec* parts, int count) {
  static const auto next = real<ssize_t(int, const iovec*, int)>("writev");
  if (is_wire_log(fd)) wait_as_told("SLOW_WIRE_LOG_MS");
  return next(fd, parts, count);
}

int flock(int fd, int operation) {
  static const auto next = real<int(int, int)>("flock");
  if (path_of(fd).starts_with("/dev/pts/")) wait_as_told("SLOW_PORTS_MS");
  return next(fd, operation);
}

int close(int fd) {
  static const auto next = real<int(int)>("close");
  if (path_of(fd).starts_with("/dev/pts/")) wait_as_told("SLOW_CLOSES_MS");
  return next(fd);
}

int access(const char* path, int mode) {
  static const auto next = real<int(const char*, int)>("access");
  if (std::string_view(path).starts_with("/dev/")) wait_as_told("SLOW_NODES_MS");
  return next(path, mode);
}

int getpwuid_r(uid_t uid, passwd* entry, char* buffer, std::size_t size, passwd** found) {
  static const auto next = real<int(uid_t, passwd*, char*, std::size_t, passwd**)>("getpwuid_r");
  wait_as_told("SLOW_USERS_MS");
  return next(uid, entry, buffer, size, found);
}

}  // extern "C"
