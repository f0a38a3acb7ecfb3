// SPDX-License-Identifier: Apache-2.0
#include "daemon/service.hpp"

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <fmt/format.h>

#include <cstdlib>
#include <cstring>

#include "base/number.hpp"
#include "base/text.hpp"

namespace lcrig {

ServiceNotifier ServiceNotifier::from_environment() {
  ServiceNotifier out;
  if (const char* path = std::getenv("NOTIFY_SOCKET")) out.path_ = path;
  if (const char* usec = std::getenv("WATCHDOG_USEC")) {
    const auto us = number_from<std::int64_t>(usec).value_or(0);
    if (us > 0) out.interval_ = std::chrono::microseconds(us / 2);
  }
  return out;
}

void ServiceNotifier::reloading(MonoTime now) const {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch());
  send(fmt::format("RELOADING=1\nMONOTONIC_USEC={}", us.count()));
}

void ServiceNotifier::status(std::string_view text) const {
  send("STATUS=" + printable(text));
}

void ServiceNotifier::extend_timeout(Duration time) const {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(time).count();
  send(fmt::format("EXTEND_TIMEOUT_USEC={}", us));
}

void ServiceNotifier::send(std::string_view state) const {
  sockaddr_un address{};
  if (path_.empty() || path_.size() >= sizeof address.sun_path) return;
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path_.data(), path_.size());
  if (path_.front() == '@') address.sun_path[0] = '\0';  // abstract name space
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return;
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path_.size());
  // A service manager that does not read must not block the rig.
  ::sendto(fd, state.data(), state.size(), MSG_NOSIGNAL | MSG_DONTWAIT,
           reinterpret_cast<const sockaddr*>(&address), length);
  ::close(fd);
}

bool lock_memory() {
  const rlimit unlimited{RLIM_INFINITY, RLIM_INFINITY};
  const bool endless = ::setrlimit(RLIMIT_MEMLOCK, &unlimited) == 0;
  if (::mlockall(MCL_CURRENT) != 0) return false;  // loads all pages that are not in memory
  // Memory that is allocated later (heap, stacks of threads) is locked when it is used. Without an
  // unlimited limit this is not done, because a program that reaches the limit gets no memory at
  // all.
  if (endless) ::mlockall(MCL_FUTURE | MCL_ONFAULT);
  return true;
}

}  // namespace lcrig
