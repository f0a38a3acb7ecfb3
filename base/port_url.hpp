// SPDX-License-Identifier: Apache-2.0
// Parses the names of ports that people write in the configuration. Used by drivers/port.cpp and by
// `lcrig doctor`:
//   serial:/dev/ttyUSB0   serial:2184:005f   serial:2184:005f:GWAIHMULA   pty:/dev/pts/4
//   tcp:host:port   tcp://host:port   tcp://[::1]:port   /dev/ttyUSB0 (a bare path)
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace lcrig {

enum class PortKind { path, usb, pty, tcp };

struct PortUrl {
  PortKind kind = PortKind::path;
  std::string path;  // path, pty
  std::uint16_t usb_vendor = 0, usb_product = 0;
  std::string usb_serial;  // empty: any
  std::string host;
  std::uint16_t tcp_port = 0;
};

// Errors: invalid_request, which names what was expected.
Result<PortUrl> parse_port_url(std::string_view url);

}  // namespace lcrig
