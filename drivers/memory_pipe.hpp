// SPDX-License-Identifier: Apache-2.0
// A wire in memory, for virtual time: the manners of a socketpair without the kernel.
#pragma once

#include <string>

#include "drivers/transport.hpp"

namespace lcrig {

// What one end writes the other one reads. An end takes 64 KiB that nobody read, then its peer
// waits; what was sent before an end closed can still be read. The ends may go in any order.
TransportPair make_memory_pipe(asio::any_io_executor executor, Clock& clock,
                               const std::string& name);

}  // namespace lcrig
