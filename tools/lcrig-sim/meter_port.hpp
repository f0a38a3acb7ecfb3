// SPDX-License-Identifier: Apache-2.0
// The simulated LCR-6100 of lcrig-sim on a pty that can be unplugged.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "drivers/lcr6100/sim.hpp"
#include "tools/lcrig-sim/pty.hpp"
#include "tools/lcrig-sim/tasks.hpp"

namespace lcrig::sim {

class MeterPort {
 public:
  // `link` is the path of a symbolic link to the pty, replaced at every plug(); empty: none.
  // Clock and tasks outlive the port.
  MeterPort(asio::any_io_executor executor, Clock& clock, Tasks& tasks, lcr6100::SimConfig config,
            lcr6100::Lcr6100Sim::Source source, std::string link);
  ~MeterPort();

  // With `other_port` the pty gets another name than before. Errors: no pty, or something other
  // than a link is at the link's path.
  Result<> plug(bool other_port = false);
  void unplug();  // idempotent
  bool is_plugged() const { return pty_.has_value(); }
  std::string url() const { return pty_ ? "pty:" + pty_->path() : ""; }
  lcr6100::Lcr6100Sim* meter() { return meter_.get(); }  // nullptr: unplugged

  // For fault scripts. Both stay in force when the cable is pulled.
  void hook(lcr6100::SimHooks hooks);
  void change(const std::function<void(lcr6100::SimFaults&)>& change);
  void heal();
  const std::string& identity() const { return config_.identity; }
  void power_on(const std::string& identity);  // while unplugged: settings are lost
  void say_unasked(std::string text);

 private:
  Result<Pty> open_pty(bool other_port) const;
  Result<> make_link() const;
  Task<> watch_clients();

  asio::any_io_executor executor_;
  Clock& clock_;
  Tasks& tasks_;
  lcr6100::SimConfig config_;
  lcr6100::Lcr6100Sim::Source source_;
  std::string link_;
  std::optional<Pty> pty_;
  std::shared_ptr<lcr6100::Lcr6100Sim> meter_;
  std::shared_ptr<lcr6100::Lcr6100Sim> unplugged_;  // keeps the settings until the next plug()
  std::string last_path_;  // of the pty
  lcr6100::SimHooks hooks_;
  lcr6100::SimFaults lasting_;  // faults of a script
};

}  // namespace lcrig::sim
