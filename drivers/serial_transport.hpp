// SPDX-License-Identifier: Apache-2.0
// Opens serial ports, for port.cpp: hardware ports with libserialport, ptys directly, because
// libserialport 0.1.1 refuses devices without an entry in sysfs. Bytes then go through FdTransport.
#pragma once

#include <memory>
#include <string>

#include "drivers/port_url.hpp"
#include "drivers/transport.hpp"

namespace lcrig {

// All supported instruments use 8 data bits, no parity, one stop bit and no flow control.
struct SerialSettings {
  SerialSettings() = default;
  explicit SerialSettings(int b) : baud(b) {}
  int baud = 115200;
};

// Errors: disconnected (no such port; the message lists those that exist), io (no rights), busy
// (another program has it open), invalid_request (not a terminal).
Result<std::unique_ptr<Transport>> open_serial(asio::any_io_executor executor, Clock& clock,
                                               const PortUrl& url, const SerialSettings& settings);
Result<std::unique_ptr<Transport>> open_pty(asio::any_io_executor executor, Clock& clock,
                                            const std::string& path);
bool is_serial_there(const PortUrl& url);  // without opening it; ptys too
// True when the path, links resolved, is the slave side of a pty.
bool is_pty(const std::string& path);

}  // namespace lcrig
