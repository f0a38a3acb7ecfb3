// SPDX-License-Identifier: Apache-2.0
// A TCP connection as a transport: the frame link, and serial servers.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "drivers/transport.hpp"

namespace lcrig {

// Errors: no_reply (the host does not answer before the deadline), disconnected (nobody listens, or
// no way to the host), invalid_request (no such host name).
Task<Result<std::unique_ptr<Transport>>> open_tcp(std::string host, std::uint16_t port,
                                                  Clock& clock, MonoTime deadline);

}  // namespace lcrig
