// SPDX-License-Identifier: Apache-2.0
// The back door of lcrig-sim: a Unix socket through which a person or a test injects faults
// (docs/simulator.md).
#pragma once

#include <boost/asio/local/stream_protocol.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "base/clock.hpp"
#include "tools/lcrig-sim/frame_port.hpp"
#include "tools/lcrig-sim/meter_port.hpp"
#include "tools/lcrig-sim/tasks.hpp"

namespace lcrig::sim {

// The bench on which the commands act. `frame` is nullptr with dead weights.
struct Bench {
  Clock& clock;
  Plant& plant;
  MeterPort& meter;
  FramePort* frame;
};

// Executes one command line. Returns the bench's state, or the reason for refusing.
Result<nlohmann::json> obey(Bench& bench, std::string_view line);

// True while the drive moves, whether or not anybody is connected.
bool is_moving(const Bench& bench);

class BackDoor {
 public:
  // The tasks must outlive the back door.
  BackDoor(const asio::any_io_executor& executor, Tasks& tasks, Bench bench);
  ~BackDoor();
  // Replaces a socket file that an earlier process left behind. Errors: io.
  Result<> listen(const std::string& path);
  void close();

 private:
  using Socket = asio::local::stream_protocol::socket;
  Task<> accept();
  Task<> serve(Socket socket);
  Task<> settle();

  Tasks& tasks_;
  Bench bench_;
  std::string path_;
  asio::local::stream_protocol::acceptor acceptor_;
};

}  // namespace lcrig::sim
