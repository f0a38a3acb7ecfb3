// SPDX-License-Identifier: Apache-2.0
// Reports the events of a run: to the watchers at the control socket, the journal, the line of the
// service manager, and the parts of App that count events. Called by the parts of App that have
// news.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace lcrig {

class ControlServer;
class RigUse;
class ServiceNotifier;
struct QueueStatus;
struct RunEvent;
struct RunOutcome;

class News {
 public:
  News(ControlServer& server, const ServiceNotifier& notifier, const RigUse& use)
      : server_(server), notifier_(notifier), use_(use) {}
  // `watcher` gets the events of every run.
  void on_event(std::function<void(const RunEvent&)> watcher) {
    watchers_.push_back(std::move(watcher));
  }

  void run_begins(std::int64_t run) const;
  void status() const;  // status of the current run, to the watchers
  // For `systemctl status`: that no client finds the daemon, else the same.
  void service_status();
  void event(const RunEvent& event) const;
  void run_ended(const RunOutcome& ended) const;
  void queue_changed(const QueueStatus& status);

 private:
  ControlServer& server_;
  const ServiceNotifier& notifier_;
  const RigUse& use_;
  std::vector<std::function<void(const RunEvent&)>> watchers_;
  std::string idle_words_ = "idle";  // what the service manager is told between runs
  bool told_trouble_ = false;
};

}  // namespace lcrig
