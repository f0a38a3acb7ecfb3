// SPDX-License-Identifier: Apache-2.0
// What systemd wants: sd_notify(3) without libsystemd, and the watchdog.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/clock.hpp"

namespace lcrig {

class ServiceNotifier {
 public:
  // Reads NOTIFY_SOCKET and WATCHDOG_USEC; silent when they are absent.
  ServiceNotifier();
  void ready() const { send("READY=1"); }
  void stopping() const { send("STOPPING=1"); }
  void watchdog() const { send("WATCHDOG=1"); }
  void status(std::string_view text) const;
  // Half of WATCHDOG_USEC, the interval of `watchdog`.
  std::optional<Duration> watchdog_interval() const { return interval_; }

 private:
  void send(std::string_view state) const;
  std::string path_;
  std::optional<Duration> interval_;
};

}  // namespace lcrig
