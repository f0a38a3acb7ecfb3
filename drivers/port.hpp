// SPDX-License-Identifier: Apache-2.0
// Opens a real port by its name (port_url.hpp). Used by the App. The kinds of ports differ only in
// how they are opened.
#pragma once

#include <memory>
#include <string>

#include "drivers/serial_transport.hpp"
#include "drivers/transport.hpp"

namespace lcrig {

// A plain path that leads to a pty is opened as a pty. Errors: those of parse_port_url,
// open_serial, open_pty and open_tcp (connect within 5 s).
Task<Result<std::unique_ptr<Transport>>> open_port(std::string url, SerialSettings settings,
                                                   Clock& clock);

// Whether the device node of a serial port exists, without opening it. A TCP port counts as there.
bool is_port_there(const std::string& url);

}  // namespace lcrig
