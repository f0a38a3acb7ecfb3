// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace lcrig::cli {

namespace {

Failure cannot(const std::string& path, int error) {
  return Failure(kFailed, fmt::format("cannot write {}: {}", path, std::strerror(error)),
                 "give another file, in a folder that you may write to");
}

Result<> write_all(int fd, std::string_view content) {
  while (!content.empty()) {
    const ssize_t n = ::write(fd, content.data(), content.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail(Errc::io, "{}", std::strerror(errno));
    content.remove_prefix(static_cast<std::size_t>(n));
  }
  return {};
}

}  // namespace

Outcome<void> write_file(const std::string& path, const std::function<Result<>(int fd)>& write) {
  struct ::stat present{};
  const bool exists = ::stat(path.c_str(), &present) == 0;
  if (exists && S_ISDIR(present.st_mode)) return cannot(path, EISDIR);
  // A device or a pipe cannot be replaced, it is written to.
  const bool special = exists && !S_ISREG(present.st_mode);
  const std::string temporary = special ? path : fmt::format("{}.{}.part", path, ::getpid());
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) return cannot(path, errno);
  auto written = write(fd);
  const bool closed = ::close(fd) == 0;
  const int close_error = errno;
  if (!special && (!written || !closed)) ::unlink(temporary.c_str());
  if (!written) {
    return Failure(kFailed, fmt::format("cannot write {}: {}", path, written.error().what), "");
  }
  if (!closed) return cannot(path, close_error);
  if (!special && std::rename(temporary.c_str(), path.c_str()) != 0) {
    const int error = errno;
    ::unlink(temporary.c_str());
    return cannot(path, error);
  }
  return {};
}

Outcome<void> write_file(const std::string& path, std::string_view content) {
  return write_file(path, [content](int fd) { return write_all(fd, content); });
}

}  // namespace lcrig::cli
