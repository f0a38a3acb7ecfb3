// SPDX-License-Identifier: Apache-2.0
#include "storage/writer_lock.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace lcrig {

namespace {

// Byte 0 of the file is locked by the writer, byte N while run N goes on. Locks of open files
// (F_OFD_*): unlike those of flock() they can be asked for without being taken.
constexpr std::int64_t kWriter = 0;

struct flock lock_of(short type, std::int64_t byte) {
  struct flock lock{};  // l_pid must be 0
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = byte;
  lock.l_len = 1;
  return lock;
}

bool take(int fd, std::int64_t byte) {
  struct flock lock = lock_of(F_WRLCK, byte);
  return ::fcntl(fd, F_OFD_SETLK, &lock) == 0;
}

Result<bool> is_locked(const std::string& database_path, std::int64_t byte) {
  const std::string file = beside_database(database_path, ".lock");
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0 && errno == ENOENT) return false;
  struct flock lock = lock_of(F_WRLCK, byte);
  const bool asked = fd >= 0 && ::fcntl(fd, F_OFD_GETLK, &lock) == 0;
  const int error = errno;
  if (fd >= 0) ::close(fd);
  if (asked) return lock.l_type != F_UNLCK;
  return fail(Errc::io,
              "{}: {}: it tells whether a run goes on; whoever may read the database must be able "
              "to read it",
              file, std::strerror(error));
}

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

std::string beside_database(const std::string& database_path, const char* suffix) {
  std::error_code unknown;
  const auto real = std::filesystem::canonical(database_path, unknown);
  return (unknown ? database_path : real.string()) + suffix;
}

Result<WriterLock> WriterLock::acquire(const std::string& database_path) {
  const std::string file = beside_database(database_path, ".lock");
  // Through a link it would empty another file.
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0644);
  if (fd < 0 && errno == ELOOP) {
    return fail(Errc::io, "{}: is a link, where the lock of the database has to be: remove it",
                file);
  }
  struct stat opened{};
  if (fd >= 0 && (::fstat(fd, &opened) != 0 || !S_ISREG(opened.st_mode))) {
    ::close(fd);
    return fail(Errc::io, "{}: is no file, where the lock of the database has to be: remove it",
                file);
  }
  if (fd < 0) {
    return fail(Errc::io, "{}: {}; check that its folder is there and writable", file,
                std::strerror(errno));
  }
  WriterLock lock(fd, file);
  if (!take(fd, kWriter)) {
    if (errno != EAGAIN && errno != EACCES) {
      return fail(Errc::io, "{}: {}", file, std::strerror(errno));
    }
    return fail(Errc::busy,
                "{}: process {} records into this database; stop it, or give another --db",
                database_path, read_owner(fd));
  }
  if (auto r = write_owner(fd, file); !r) return fail(r.error());
  return lock;
}

WriterLock::WriterLock(WriterLock&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), file_(std::move(other.file_)) {}
WriterLock& WriterLock::operator=(WriterLock&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(file_, other.file_);
  return *this;
}
WriterLock::~WriterLock() {
  if (fd_ >= 0) ::close(fd_);
}

Result<> WriterLock::begin_run(std::int64_t run) {
  if (take(fd_, run)) return {};
  return fail(Errc::io, "{}: {}: it cannot be told to others that run {} goes on", file_,
              std::strerror(errno), run);
}

void WriterLock::end_run() {
  struct flock none = lock_of(F_UNLCK, kWriter + 1);
  none.l_len = 0;  // and all bytes after it
  ::fcntl(fd_, F_OFD_SETLK, &none);
}

Result<bool> has_writer(const std::string& database_path) {
  return is_locked(database_path, kWriter);
}

Result<bool> is_being_recorded(const std::string& database_path, std::int64_t run) {
  return is_locked(database_path, run);
}

}  // namespace lcrig
