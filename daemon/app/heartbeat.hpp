// SPDX-License-Identifier: Apache-2.0
// Reports ten times a second that the daemon works, to watchers and to the service manager. Feeds
// systemd's watchdog only while runner, sampler and recorder move. It runs on the thread that does
// the work, so it notices when that thread is stuck. Owned by App.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/task.hpp"
#include "base/time.hpp"
#include "daemon/liveness.hpp"

namespace lcrig {

class InstrumentFactory;
class News;
class Recorder;
class RigUse;
class ServiceNotifier;

class Heartbeat {
 public:
  // References to App's members; all must outlive it.
  struct Parts {
    const std::unique_ptr<Recorder>& recorder;
    const InstrumentFactory& rig;
    const RigUse& use;
    const ServiceNotifier& notifier;
    News& news;
  };
  Heartbeat(Clock& clock, const Parts& parts);

  Task<> run();  // until the daemon ends and no session is left
  // The longest time by which the event loop was late since the daemon started.
  Duration worst_lateness() const { return lag_.worst(); }

 private:
  bool is_working();
  void tell_service(bool working) const;
  void tell_lag(Duration late);

  Clock& clock_;
  Parts parts_;
  Liveness liveness_;
  LoopLag lag_{std::chrono::milliseconds(200)};
  std::vector<std::string> stuck_;
  MonoTime lag_told_;
};

}  // namespace lcrig
