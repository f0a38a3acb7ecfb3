// SPDX-License-Identifier: Apache-2.0
// The simulated LCR-6100 of lcrig-sim on a pty that can be unplugged. Used by main.cpp and faults.
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
  // `link` is the path of a symbolic link to the pty, which every plug() replaces; empty: there is
  // none. Clock and tasks must outlive the port.
  MeterPort(asio::any_io_executor executor, Clock& clock, Tasks& tasks, lcr6100::SimConfig config,
            lcr6100::Lcr6100Sim::Source source, std::string link);
  ~MeterPort();

  // With `other_port` the pty gets another name than before. Errors: there is no pty; the path of
  // the link holds something other than a link.
  Result<> plug(bool other_port = false);
  void unplug();  // idempotent
  bool is_plugged() const { return pty_.has_value(); }
  std::string url() const { return pty_ ? "pty:" + pty_->path() : ""; }
  lcr6100::Lcr6100Sim* meter() { return meter_.get(); }  // nullptr: unplugged

  // For fault scripts. Hooks and changes stay in force when the cable is pulled.
  void hook(lcr6100::SimHooks hooks);
  void change(const std::function<void(lcr6100::SimFaults&)>& change);
  void heal();
  const std::string& identity() const { return config_.identity; }
  void power_on(const std::string& identity);  // the settings are lost
  void turn(PanelKey key, const std::string& to);
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
  std::string last_path_;  // last path of the pty
  lcr6100::SimHooks hooks_;
  lcr6100::SimFaults lasting_;  // the faults of a script
};

}  // namespace lcrig::sim
