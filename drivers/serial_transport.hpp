// SPDX-License-Identifier: Apache-2.0
// Opens serial ports, for port.cpp: hardware ports with libserialport, ptys directly, because
// libserialport 0.1.1 refuses devices without an entry in sysfs. Bytes then go through FdTransport.
// Opening may block (a hub that does not answer) and may run on any thread.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "base/port_url.hpp"
#include "drivers/transport.hpp"

namespace lcrig {

// All supported instruments use 8 data bits, no parity, one stop bit and no flow control.
struct SerialSettings {
  SerialSettings() = default;
  explicit SerialSettings(int b) : baud(b) {}
  int baud = 115200;
};

// An open port that no event loop uses yet. It closes unless it becomes a transport.
class OpenedPort {
 public:
  OpenedPort(int fd, std::string name, std::function<void(int)> closer)
      : fd_(fd), name_(std::move(name)), closer_(std::move(closer)) {}
  OpenedPort(OpenedPort&& other) noexcept
      : fd_(std::exchange(other.fd_, -1)),
        name_(std::move(other.name_)),
        closer_(std::move(other.closer_)) {}
  OpenedPort& operator=(OpenedPort&& other) noexcept {
    std::swap(fd_, other.fd_);
    std::swap(name_, other.name_);
    std::swap(closer_, other.closer_);
    return *this;
  }
  OpenedPort(const OpenedPort&) = delete;
  OpenedPort& operator=(const OpenedPort&) = delete;
  ~OpenedPort() {
    if (fd_ >= 0) closer_(fd_);
  }
  std::unique_ptr<Transport> to_transport(asio::any_io_executor executor, Clock& clock) &&;

 private:
  int fd_;
  std::string name_;
  std::function<void(int)> closer_;
};

// Errors: disconnected (no such port; the message lists those that exist), io (no rights), busy
// (another program has it open), invalid_request (not a terminal).
Result<OpenedPort> open_serial(const PortUrl& url, const SerialSettings& settings);
Result<OpenedPort> open_pty(const std::string& path);
bool is_serial_there(const PortUrl& url);  // without opening it; also for ptys
// True when the path, links resolved, is the slave side of a pty.
bool is_pty(const std::string& path);

}  // namespace lcrig
