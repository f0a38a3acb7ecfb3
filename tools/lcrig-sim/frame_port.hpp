// SPDX-License-Identifier: Apache-2.0
// The simulated load frame of lcrig-sim behind its gateway: frame-link/1 on loopback TCP or on a
// pty. Used by main.cpp and the fault scripts.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "drivers/zwick/sim.hpp"
#include "tools/lcrig-sim/pty.hpp"
#include "tools/lcrig-sim/tasks.hpp"

namespace lcrig::sim {

class FramePort {
 public:
  // Clock, tasks and scene must outlive the port.
  FramePort(asio::any_io_executor executor, Clock& clock, Tasks& tasks, FrameScene& scene,
            ZwickSimSettings settings);

  // Call one of the two, once. Port 0: any free port. Errors: the port is taken; there is no pty.
  Result<> listen(std::uint16_t tcp_port);
  Result<> open_pty();
  const std::string& url() const { return url_; }  // "tcp://127.0.0.1:40123", "pty:/dev/pts/6"

  // unplug() cuts the line, and TCP refuses new clients. plug() accepts them again on the same
  // port.
  void unplug();
  Result<> plug();
  // For fault scripts. Hooks and changes stay in force when the connection ends.
  void hook(ZwickSimHooks hooks);
  void change(const std::function<void(ZwickSimFaults&)>& change);
  void heal();
  void forget();  // as after the machine was switched off and on
  void restart(bool forgets_zero);  // restarts the program of the gateway

  ZwickSim* gateway() { return gateway_.get(); }  // nullptr: no client is connected

 private:
  Result<> bind();
  Task<> accept();
  Task<> admit(int fd);
  void serve(int fd, const std::string& name);

  asio::any_io_executor executor_;
  Clock& clock_;
  Tasks& tasks_;
  FrameScene& scene_;
  ZwickSimSettings settings_;
  std::string url_;
  std::uint16_t tcp_port_ = 0;
  asio::ip::tcp::acceptor acceptor_;
  std::optional<Pty> pty_;
  std::shared_ptr<ZwickSim> gateway_;
  std::shared_ptr<ZwickSim> parked_;  // keeps the machine while no client is connected
  ZwickSimHooks hooks_;
  ZwickSimFaults lasting_;  // the faults of a script
};

}  // namespace lcrig::sim
