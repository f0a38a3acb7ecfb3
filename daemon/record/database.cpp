// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/database.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "storage/runs.hpp"

namespace lcrig {

namespace {

std::string read_owner(int fd) {
  char text[32] = {};
  const ssize_t n = ::pread(fd, text, sizeof text - 1, 0);
  std::string owner(text, n > 0 ? static_cast<std::size_t>(n) : 0);
  while (!owner.empty() && owner.back() == '\n') owner.pop_back();
  return owner.empty() ? "unknown" : owner;
}

Result<> write_owner(int fd, const std::string& file) {
  const std::string pid = fmt::format("{}\n", ::getpid());
  if (::ftruncate(fd, 0) != 0 ||
      ::pwrite(fd, pid.data(), pid.size(), 0) != static_cast<ssize_t>(pid.size())) {
    return fail(Errc::io, "{}: {}; free some space on this disk", file, std::strerror(errno));
  }
  return {};
}

}  // namespace

Result<WriterLock> WriterLock::acquire(const std::string& database_path) {
  const std::string file = database_path + ".lock";
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) {
    return fail(Errc::io, "{}: {}; check that its folder is there and writable", file,
                std::strerror(errno));
  }
  WriterLock lock(fd);
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return fail(Errc::io, "{}: {}", file, std::strerror(errno));
    return fail(Errc::busy,
                "{}: process {} records into this database; stop it, or give another --db",
                database_path, read_owner(fd));
  }
  if (auto r = write_owner(fd, file); !r) return fail(r.error());
  return lock;
}

WriterLock::WriterLock(WriterLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
WriterLock& WriterLock::operator=(WriterLock&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}
WriterLock::~WriterLock() {
  if (fd_ >= 0) ::close(fd_);
}

Result<OwnedDatabase> open_as_owner(const std::string& path, std::int64_t now_unix_ns,
                                    const std::string& vfs) {
  auto lock = WriterLock::acquire(path);
  if (!lock) return fail(lock.error());
  auto db = open_read_write(path, vfs);
  if (!db) return fail(db.error());
  auto interrupted = close_orphaned_runs(*db, now_unix_ns);
  if (!interrupted) return fail(interrupted.error());
  return OwnedDatabase{std::move(*lock), std::move(*db), std::move(*interrupted)};
}

}  // namespace lcrig
