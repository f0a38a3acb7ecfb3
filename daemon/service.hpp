// SPDX-License-Identifier: Apache-2.0
// The daemon as a service: sd_notify(3) without libsystemd, the watchdog, and its memory. App and
// main use it.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/time.hpp"

namespace lcrig {

// What a daemon that stops asks for at a time (extend_timeout), while all its parts move.
inline constexpr Duration kStopExtension = std::chrono::seconds(30);

class ServiceNotifier {
 public:
  ServiceNotifier() = default;  // silent
  // Reads NOTIFY_SOCKET and WATCHDOG_USEC; silent when they are absent.
  static ServiceNotifier from_environment();
  void ready() const { send("READY=1"); }
  void stopping() const { send("STOPPING=1"); }
  // The config file is read again; `ready` says that this is over.
  void reloading(MonoTime now) const;
  void watchdog() const { send("WATCHDOG=1"); }
  void status(std::string_view text) const;
  // Begins the time anew after which systemd kills a service that is stopping: TimeoutStopSec may
  // be shorter than `finally`.
  void extend_timeout(Duration time) const;
  // Half of WATCHDOG_USEC, the interval of `watchdog`.
  std::optional<Duration> watchdog_interval() const { return interval_; }

 private:
  void send(std::string_view state) const;
  std::string path_;
  std::optional<Duration> interval_;
};

// Keeps this program in memory (mlockall(2)). A computer that runs short of it takes the code that
// was idle for longest first, such as that of a stop, which then waits for the disk: 70 pages,
// measured. False: not allowed (RLIMIT_MEMLOCK; the unit has LimitMEMLOCK=infinity), nothing
// changed. Before any thread is started.
bool lock_memory();

}  // namespace lcrig
