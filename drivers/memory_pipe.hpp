// SPDX-License-Identifier: Apache-2.0
// A pipe in memory between driver and simulator, for virtual time. It behaves like a socketpair
// without the kernel. Used by the simulated bench and the tests.
#pragma once

#include <functional>
#include <string>

#include "base/time.hpp"
#include "drivers/transport.hpp"

namespace lcrig {

// Makes the wire between a driver and its simulator: in memory, or a socketpair.
using MakeWire =
    std::function<Result<TransportPair>(asio::any_io_executor, Clock&, const std::string& name)>;

// Each end reads what the other wrote. At most 64 KiB wait unread at an end; a writer waits for
// room. Bytes sent before an end closed can still be read. The ends may be destroyed in any order.
TransportPair make_memory_pipe(asio::any_io_executor executor, Clock& clock,
                               const std::string& name);

}  // namespace lcrig
