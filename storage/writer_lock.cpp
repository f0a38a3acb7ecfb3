// SPDX-License-Identifier: Apache-2.0
#include "storage/writer_lock.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <sstream>
#include <utility>

#include "base/whole_file.hpp"

namespace lcrig {

namespace {

constexpr std::int64_t kNoRun = 0;

// Locks the whole file by its open file description (F_OFD_*). Unlike a flock() lock, this one can
// be queried without being taken.
struct flock lock_of(short type) {
  struct flock lock{};  // l_pid must be 0
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  return lock;
}

bool take(int fd) {
  struct flock lock = lock_of(F_WRLCK);
  return ::fcntl(fd, F_OFD_SETLK, &lock) == 0;
}

struct Sign {
  std::string owner = "unknown";  // process id
  std::int64_t run = kNoRun;
};

// Always of the same length, so that one write replaces all of it.
std::string text_of(std::int64_t run) {
  return fmt::format("{:<10}\nrun {:<19}\n", ::getpid(), run);
}

Sign read_text(int fd) {
  char text[64] = {};
  const ssize_t n = ::pread(fd, text, sizeof text - 1, 0);
  std::istringstream words(std::string(text, n > 0 ? static_cast<std::size_t>(n) : 0));
  Sign sign;
  std::string run;
  words >> sign.owner >> run >> sign.run;
  return sign;
}

// nullopt: no process writes the database.
Result<std::optional<Sign>> read_sign(const std::string& database_path) {
  const std::string file = beside_database(database_path, ".lock");
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0 && errno == ENOENT) return std::nullopt;
  struct flock lock = lock_of(F_RDLCK);  // conflicts with an exclusive lock only
  const bool asked = fd >= 0 && ::fcntl(fd, F_OFD_GETLK, &lock) == 0;
  const int error = errno;
  std::optional<Sign> sign;
  if (asked && lock.l_type != F_UNLCK) sign = read_text(fd);
  if (fd >= 0) ::close(fd);
  if (asked) return sign;
  return fail(Errc::io,
              "{}: {}: it tells whether a run goes on; whoever may read the database must be able "
              "to read it",
              file, std::strerror(error));
}

Result<int> open_own(const std::string& file) {
  // Following a link would lock another file.
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
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
    return fail(Errc::io,
                "{}: {}; check that its folder is there and writable, and that the file, if there "
                "is one, is this user's",
                file, std::strerror(errno));
  }
  return fd;
}

tl::unexpected<Error> held_by_other(const std::string& database_path) {
  const auto sign = read_sign(database_path);
  return fail(Errc::busy,
              "{}: process {} records into this database; stop it, or give another --db",
              database_path, (sign && *sign ? **sign : Sign()).owner);
}

}  // namespace

std::string beside_database(const std::string& database_path, const char* suffix) {
  std::error_code unknown;
  const auto real = std::filesystem::canonical(database_path, unknown);
  return (unknown ? database_path : real.string()) + suffix;
}

Result<WriterLock> WriterLock::acquire(const std::string& database_path) {
  const std::string file = beside_database(database_path, ".writer");
  auto opened = open_own(file);
  if (!opened) return fail(opened.error());
  WriterLock lock(*opened);
  if (!take(lock.fd_)) {
    if (errno != EAGAIN && errno != EACCES) {
      return fail(Errc::io, "{}: {}", file, std::strerror(errno));
    }
    return held_by_other(database_path);
  }
  const auto written = has_writer(database_path);  // an older lcrig takes only the lock of the sign
  if (written && *written) return held_by_other(database_path);
  if (auto r = lock.put_up_sign(beside_database(database_path, ".lock")); !r) {
    return fail(r.error());
  }
  return lock;
}

Result<> WriterLock::put_up_sign(const std::string& file) {
  auto sign = PartFile::create(file);
  if (!sign) {
    return fail(Errc::io, "{}; check that its folder is there and writable", sign.error().what);
  }
  sign_file_ = file;
  sign_ = ::fcntl(sign->fd(), F_DUPFD_CLOEXEC, 0);  // the same open file description, so the same
                                                    // lock
  if (sign_ < 0 || !take(sign_)) return fail(Errc::io, "{}: {}", file, std::strerror(errno));
  if (auto r = write_sign(kNoRun); !r) return r;
  if (auto r = sign->replace(); !r) {
    return fail(Errc::io, "{}: the lock of the database has to be there; move away what is there",
                r.error().what);
  }
  return {};
}

Result<> WriterLock::write_sign(std::int64_t run) const {
  const std::string text = text_of(run);
  if (::pwrite(sign_, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size())) return {};
  return fail(Errc::io, "{}: {}; free some space on this disk", sign_file_, std::strerror(errno));
}

WriterLock::WriterLock(WriterLock&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      sign_(std::exchange(other.sign_, -1)),
      sign_file_(std::move(other.sign_file_)) {}
WriterLock& WriterLock::operator=(WriterLock&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(sign_, other.sign_);
  std::swap(sign_file_, other.sign_file_);
  return *this;
}
WriterLock::~WriterLock() {
  if (sign_ >= 0) ::close(sign_);
  if (fd_ >= 0) ::close(fd_);
}

Result<> WriterLock::begin_run(std::int64_t run) {
  auto written = write_sign(run);
  if (written) return written;
  return fail(Errc::io, "{}: it cannot be told to others that run {} goes on", written.error().what,
              run);
}

// A failure does no harm: the sign then names a run that has ended, and nobody asks for that one.
void WriterLock::end_run() {
  static_cast<void>(write_sign(kNoRun));
}

Result<bool> has_writer(const std::string& database_path) {
  auto sign = read_sign(database_path);
  if (!sign) return fail(sign.error());
  return sign->has_value();
}

Result<bool> is_being_recorded(const std::string& database_path, std::int64_t run) {
  auto sign = read_sign(database_path);
  if (!sign) return fail(sign.error());
  return sign->has_value() && (*sign)->run == run;
}

}  // namespace lcrig
