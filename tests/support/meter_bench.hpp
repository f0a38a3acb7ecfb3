// SPDX-License-Identifier: Apache-2.0
// An LCR-6100 driver and its simulator joined by a wire in memory, in virtual time. For tests of
// the meter.
#pragma once

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "drivers/lcr6100/driver.hpp"
#include "drivers/lcr6100/sim.hpp"
#include "drivers/memory_pipe.hpp"
#include "tests/support/run_task.hpp"

namespace lcrig::support {

inline Electrical seven_picofarad(MonoTime) {
  Electrical e;
  e.capacitance_F = 7.2914e-12;
  e.dissipation = 0.004;
  return e;
}

struct MeterBench {
  using Wrap = std::function<std::unique_ptr<Transport>(std::unique_ptr<Transport>, Clock&)>;

  explicit MeterBench(std::string serial = "", lcr6100::SimConfig config = {},
                      lcr6100::Lcr6100Sim::Source source = seven_picofarad, Wrap wrap = {}) {
    auto near = connect();
    if (wrap) near = wrap(std::move(near), clock);
    sim.emplace(std::move(far), clock, std::move(config), std::move(source));
    meter.emplace(std::move(near), clock, std::move(serial));
    start();
  }
  explicit MeterBench(lcr6100::Lcr6100Sim::Recording recording) {
    auto near = connect();
    sim.emplace(std::move(far), clock, lcr6100::SimConfig(), std::move(recording));
    meter.emplace(std::move(near), clock);
    start();
  }
  ~MeterBench() {
    sim->close();
    meter->close();
    clock.run(io, [] { return false; });
  }
  template <class T>
  T run(Task<T> task) {
    return run_task(io, clock, std::move(task));
  }
  double seconds() const { return to_seconds(clock.now().time_since_epoch()); }

  asio::io_context io;
  VirtualClock clock;
  std::unique_ptr<Transport> far;
  std::optional<lcr6100::Lcr6100Sim> sim;
  std::optional<lcr6100::Lcr6100> meter;

 private:
  std::unique_ptr<Transport> connect() {
    auto pair = make_memory_pipe(io.get_executor(), clock, "sim:lcr");
    far = std::move(pair.far);
    return std::move(pair.near);
  }
  void start() { asio::co_spawn(io, sim->run(), asio::detached); }
};

}  // namespace lcrig::support
