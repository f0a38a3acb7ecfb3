// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig-sim/pty.hpp"

#include <fcntl.h>
#include <pty.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace lcrig::sim {

Result<Pty> Pty::open() {
  int master = -1, device = -1;
  std::array<char, 64> name{};
  termios raw{};
  ::cfmakeraw(&raw);
  raw.c_cflag |= CREAD;
  raw.c_cc[VMIN] = 1;
  if (::openpty(&master, &device, name.data(), &raw, nullptr) != 0) {
    return fail(Errc::io, "no pseudo-terminal: {}", std::strerror(errno));
  }
  ::fcntl(master, F_SETFD, FD_CLOEXEC);
  ::fcntl(device, F_SETFD, FD_CLOEXEC);
  return Pty(master, device, name.data());
}

Pty::Pty(Pty&& other) noexcept
    : master_(std::exchange(other.master_, -1)),
      device_(std::exchange(other.device_, -1)),
      path_(std::move(other.path_)) {}

Pty& Pty::operator=(Pty&& other) noexcept {
  std::swap(master_, other.master_);
  std::swap(device_, other.device_);
  std::swap(path_, other.path_);
  return *this;
}

Pty::~Pty() {
  if (device_ >= 0) ::close(device_);
  if (master_ >= 0) ::close(master_);
}

void Pty::forget_dead_client() const {
  int exclusive = 0;
  if (::ioctl(device_, TIOCGEXCL, &exclusive) != 0 || exclusive == 0) return;
  // A client that is alive also holds this lock. The kernel releases it when the process ends.
  if (::flock(device_, LOCK_EX | LOCK_NB) != 0) return;
  ::ioctl(device_, TIOCNXCL);
  ::tcflush(device_, TCIFLUSH);  // discards answers that nobody read
  ::flock(device_, LOCK_UN);
}

}  // namespace lcrig::sim
