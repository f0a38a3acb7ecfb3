// SPDX-License-Identifier: Apache-2.0
// The daemon as a service: sd_notify(3) without libsystemd, the watchdog, and its memory. Used by
// App and main.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/time.hpp"

namespace lcrig {

// The time that a stopping daemon requests at once (extend_timeout), while all its parts move.
inline constexpr Duration kStopExtension = std::chrono::seconds(30);

class ServiceNotifier {
 public:
  ServiceNotifier() = default;  // silent
  // Reads NOTIFY_SOCKET and WATCHDOG_USEC; silent if they are absent.
  static ServiceNotifier from_environment();
  void ready() const { send("READY=1"); }
  void stopping() const { send("STOPPING=1"); }
  // The config file is being read again; call `ready` afterwards.
  void reloading(MonoTime now) const;
  void watchdog() const { send("WATCHDOG=1"); }
  void status(std::string_view text) const;
  // Restarts the time after which systemd kills a stopping service, because TimeoutStopSec may be
  // shorter than `finally`.
  void extend_timeout(Duration time) const;
  // Half of WATCHDOG_USEC, the interval for calling `watchdog`.
  std::optional<Duration> watchdog_interval() const { return interval_; }

 private:
  void send(std::string_view state) const;
  std::string path_;
  std::optional<Duration> interval_;
};

// Locks this program into memory (mlockall(2)). A computer short of memory drops the code that was
// idle for longest, such as that of a stop, which then has to wait for the disk: 70 pages,
// measured. False: not allowed (RLIMIT_MEMLOCK; the unit has LimitMEMLOCK=infinity), and nothing
// changed. Call it before any thread is started.
bool lock_memory();

}  // namespace lcrig
