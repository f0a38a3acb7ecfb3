// SPDX-License-Identifier: Apache-2.0
// Reads the config file again while the daemon runs (SIGHUP), and takes from it what can be taken
// now. App owns it.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <functional>

#include "daemon/app/rig_use.hpp"
#include "daemon/config_reload.hpp"
#include "daemon/queue/plans.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/service.hpp"

namespace lcrig {

class ConfigTaker {
 public:
  // Reads and checks the file; on a thread of its own. Empty: there is none.
  using Load = std::function<Result<Config>()>;
  // What App shares with it; all outlive it. Only this changes `config`.
  struct Parts {
    Config& config;
    Load load;
    const ServiceNotifier& notifier;
    RigUse& use;
    InstrumentFactory& rig;
    QueuePlans& plans;
  };
  ConfigTaker(asio::any_io_executor executor, Clock& clock, Parts parts)
      : executor_(std::move(executor)),
        clock_(clock),
        parts_(std::move(parts)),
        reload_(parts_.config) {}

  // A bad file changes nothing, and a run notices nothing. One call after the other.
  Task<> reload();
  // The rig is idle: takes what waited for that.
  void take_when_idle();
  ConfigView view() const { return reload_.view(); }

 private:
  void take(Config wanted);
  void changed();

  asio::any_io_executor executor_;
  Clock& clock_;
  Parts parts_;
  ConfigReload reload_;
};

}  // namespace lcrig
