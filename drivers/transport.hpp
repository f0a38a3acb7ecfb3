// SPDX-License-Identifier: Apache-2.0
// The byte stream between a driver and its instrument or simulator. Every wait has a deadline.
// Drivers and simulators talk through it; port.hpp, the simulated bench and lcrig-sim open them.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "base/task.hpp"
#include "base/time.hpp"

namespace lcrig {

class Transport {
 public:
  virtual ~Transport() = default;
  Transport() = default;
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  // Reads at least one byte. Errors: no_reply (deadline), disconnected (end of file, unplug), io.
  virtual Task<Result<std::size_t>> read_some(std::span<char> buffer, MonoTime deadline) = 0;
  // Writes everything. Errors: io (deadline: the other side does not read), disconnected. `bytes`
  // must stay alive until the task ends.
  virtual Task<Result<>> write_all(std::string_view bytes, MonoTime deadline) = 0;
  // Ends all current and future waits with `disconnected`. Idempotent.
  virtual void close() = 0;
  // The port's name for people: "serial:/dev/ttyUSB0", "tcp:127.0.0.1:4711", "sim:lcr".
  virtual const std::string& name() const = 0;
};

// The two ends of a wire: a driver on one, a simulator on the other.
struct TransportPair {
  std::unique_ptr<Transport> near, far;
};

}  // namespace lcrig
