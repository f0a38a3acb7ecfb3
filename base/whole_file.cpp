// SPDX-License-Identifier: Apache-2.0
#include "base/whole_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace lcrig {

namespace {

tl::unexpected<Error> system_error(const std::string& path) {
  return fail(Errc::io, "{}: {}", path, std::strerror(errno));
}

// A name that is free, and stays ours. -1 and errno: none of a hundred was.
int open_beside(const std::string& path, std::string& name) {
  int fd = -1;
  for (int n = 0; n < 100; ++n) {
    name = fmt::format("{}.{}-{}.part", path, ::getpid(), n);
    fd = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (fd >= 0 || errno != EEXIST) break;
  }
  return fd;
}

}  // namespace

Result<> write_text(int fd, const std::string& path, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(fd, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return system_error(path);
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  return {};
}

Result<> write_whole_file(const std::string& path, const std::function<Result<>(int fd)>& write) {
  std::string name;
  const int fd = open_beside(path, name);
  if (fd < 0) return system_error(path);
  Result<> done = write(fd);
  if (done && ::fsync(fd) != 0) done = system_error(path);
  if (::close(fd) != 0 && done) done = system_error(path);
  if (done && std::rename(name.c_str(), path.c_str()) != 0) done = system_error(path);
  if (!done) ::unlink(name.c_str());
  return done;
}

Result<> write_whole_file(const std::string& path, std::string_view text) {
  return write_whole_file(path, [&](int fd) { return write_text(fd, path, text); });
}

}  // namespace lcrig
