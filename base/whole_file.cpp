// SPDX-License-Identifier: Apache-2.0
#include "base/whole_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

namespace lcrig {

namespace {

tl::unexpected<Error> system_error(const std::string& path) {
  return fail(Errc::io, "{}: {}", path, std::strerror(errno));
}

// Opens a new file under a name that no other process uses. -1 with errno: none of a hundred names
// was free.
int open_beside(const std::string& path, std::string& name) {
  int fd = -1;
  for (int n = 0; n < 100; ++n) {
    name = fmt::format("{}.{}-{}.part", path, ::getpid(), n);
    fd = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (fd >= 0 || errno != EEXIST) break;
  }
  return fd;
}

// True for names beside a database that SQLite or lcrig uses, even if the file is empty.
bool belongs_to_database(const std::string& path) {
  std::error_code unknown;
  const std::string name = std::filesystem::weakly_canonical(path, unknown).string();
  for (const char* suffix : {"-wal", "-shm", ".lock", ".reserve"}) {
    if (name.ends_with(suffix) || path.ends_with(suffix)) return true;
  }
  return false;
}

// The first 4 KiB; nullopt with errno: not readable.
std::optional<std::string> head_of(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return std::nullopt;
  std::array<char, 4096> buffer;
  const ssize_t n = ::read(fd, buffer.data(), buffer.size());
  const int error = errno;
  ::close(fd);
  errno = error;
  if (n < 0) return std::nullopt;
  return std::string(buffer.data(), static_cast<std::size_t>(n));
}

// Syncs the folder, so that a power cut does not lose the new name. A folder that cannot be synced
// belongs to somebody else; this is not an error.
void sync_folder_of(const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  const int fd = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

}  // namespace

Result<PartFile> PartFile::create(const std::string& path) {
  std::string name;
  const int fd = open_beside(path, name);
  if (fd < 0) return system_error(path);
  return PartFile(path, std::move(name), fd);
}

PartFile::PartFile(std::string path, std::string name, int fd)
    : path_(std::move(path)), name_(std::move(name)), fd_(fd) {}
PartFile::PartFile(PartFile&& other) noexcept
    : path_(std::move(other.path_)),
      name_(std::exchange(other.name_, {})),
      fd_(std::exchange(other.fd_, -1)) {}
PartFile::~PartFile() {
  if (fd_ >= 0) ::close(fd_);
  if (!name_.empty()) ::unlink(name_.c_str());
}

Result<> PartFile::sync_and_close() {
  Result<> done;
  if (::fsync(fd_) != 0) done = system_error(path_);
  if (::close(std::exchange(fd_, -1)) != 0 && done) done = system_error(path_);
  return done;
}

Result<> PartFile::open_to_all() {
  if (::fchmod(fd_, 0644) != 0) return system_error(path_);
  return {};
}

Result<> PartFile::replace() {
  if (auto closed = sync_and_close(); !closed) return closed;
  if (std::rename(name_.c_str(), path_.c_str()) != 0) return system_error(path_);
  name_.clear();
  return {};
}

Result<> PartFile::put_new() {
  if (auto closed = sync_and_close(); !closed) return closed;
  if (auto named = take_free_name(); !named) return named;
  sync_folder_of(path_);
  return {};
}

Result<> PartFile::take_free_name() {
  if (::renameat2(AT_FDCWD, name_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE) == 0) {
    name_.clear();
    return {};
  }
  if (errno != EINVAL && errno != ENOSYS) return system_error(path_);
  // Network file systems may support hard links only. The destructor removes the other name.
  if (::link(name_.c_str(), path_.c_str()) != 0) return system_error(path_);
  return {};
}

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
  auto part = PartFile::create(path);
  if (!part) return fail(part.error());
  if (auto written = write(part->fd()); !written) return written;
  return part->replace();
}

Result<> require_earlier_output(const std::string& path, std::string_view mark) {
  struct ::stat present{};
  if (::stat(path.c_str(), &present) != 0 || !S_ISREG(present.st_mode)) return {};
  const auto head = head_of(path);
  if (!head) return system_error(path);
  if (head->starts_with("SQLite format 3") || (belongs_to_database(path) && head->empty())) {
    return fail(Errc::invalid_request, "{}: is of a database, which would be lost", path);
  }
  if (head->empty() || head->find(mark) != head->npos) return {};
  return fail(Errc::invalid_request, "{}: holds something else, which would be lost", path);
}

Result<> write_whole_file(const std::string& path, std::string_view text) {
  return write_whole_file(path, [&](int fd) { return write_text(fd, path, text); });
}

}  // namespace lcrig
