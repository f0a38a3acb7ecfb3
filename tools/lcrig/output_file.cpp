// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/whole_file.hpp"

namespace lcrig::cli {

namespace {

// A device or a pipe cannot be replaced, so it is written to.
Result<> write_to(const std::string& path, const std::function<Result<>(int fd)>& write) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (fd < 0) return fail(Errc::io, "{}: {}", path, std::strerror(errno));
  Result<> done = write(fd);
  if (::close(fd) != 0 && done) done = fail(Errc::io, "{}: {}", path, std::strerror(errno));
  return done;
}

}  // namespace

Outcome<void> require_replaceable(const std::string& path, const char* mark) {
  const auto replaceable = require_earlier_output(path, mark);
  if (replaceable) return {};
  return Failure(kFailed, "cannot write " + replaceable.error().what,
                 "give the name of a new file, or remove that one yourself");
}

Outcome<void> write_file(const std::string& path, const char* mark,
                         const std::function<Result<>(int fd)>& write) {
  if (auto replaceable = require_replaceable(path, mark); !replaceable) return replaceable;
  struct ::stat present{};
  const bool exists = ::stat(path.c_str(), &present) == 0;
  Result<> done;
  if (exists && S_ISDIR(present.st_mode)) {
    done = fail(Errc::io, "{}: {}", path, std::strerror(EISDIR));
  } else if (exists && !S_ISREG(present.st_mode)) {
    done = write_to(path, write);
  } else {
    done = write_whole_file(path, write);
  }
  if (done) return {};
  return Failure(kFailed, "cannot write " + done.error().what,
                 "give another file, in a folder that you may write to");
}

Outcome<void> write_file(const std::string& path, const char* mark, std::string_view content) {
  return write_file(path, mark, [&](int fd) { return write_text(fd, path, content); });
}

}  // namespace lcrig::cli
