// SPDX-License-Identifier: Apache-2.0
// A TCP connection as a transport, for the frame link and for serial device servers. Used by
// port.cpp.
#pragma once

#include <boost/system/error_code.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "drivers/transport.hpp"

namespace lcrig {

// Errors: no_reply (the host does not answer before the deadline), disconnected (nobody listens,
// the host cannot be reached, or its name is not found).
Task<Result<std::unique_ptr<Transport>>> open_tcp(std::string host, std::uint16_t port,
                                                  Clock& clock, MonoTime deadline);

// Why a connection failed, and what to do about it.
Error connect_error(const std::string& name, const boost::system::error_code& error);

}  // namespace lcrig
