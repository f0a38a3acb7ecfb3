// SPDX-License-Identifier: Apache-2.0
// Reads the config file again while the daemon runs (SIGHUP), and applies the changes that can be
// applied now. Owned by App.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <functional>

#include "base/result.hpp"
#include "base/task.hpp"
#include "daemon/config_reload.hpp"

namespace lcrig {

class InstrumentFactory;
class QueuePlans;
class RigUse;
class ServiceNotifier;

class ConfigTaker {
 public:
  // Reads and checks the file on a thread of its own. Empty: there is no file.
  using Load = std::function<Result<Config>()>;
  // References to App's members; all must outlive it. Only ConfigTaker changes `config`.
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

  // A file with mistakes changes nothing, and a run is not disturbed. Calls must not overlap.
  Task<> reload();
  // The rig is idle: applies the changes that waited for that.
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
