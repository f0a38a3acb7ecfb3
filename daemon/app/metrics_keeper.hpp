// SPDX-License-Identifier: Apache-2.0
// The daemon's health figures, on request and as a file for node-exporter. Owned by App.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "base/condition.hpp"
#include "base/result.hpp"
#include "base/task.hpp"
#include "daemon/control/messages.hpp"

namespace lcrig {

class Heartbeat;
class Recorder;
class RigUse;
struct Config;

class MetricsKeeper {
 public:
  // References to App's members; all must outlive it.
  struct Parts {
    const Config& config;
    const std::unique_ptr<Recorder>& recorder;
    const Heartbeat& heartbeat;
    RigUse& use;
    std::function<DaemonStatus()> status;
  };
  MetricsKeeper(asio::any_io_executor executor, Clock& clock, Parts parts)
      : executor_(std::move(executor)), clock_(clock), parts_(std::move(parts)), free_(clock) {}

  void count(const RunEvent& event) { ++events_[std::string(to_string(event.kind.kind()))]; }
  Task<Result<std::string>> text();
  Task<> write();  // writes the file until the daemon ends

 private:
  asio::any_io_executor executor_;
  Clock& clock_;
  Parts parts_;
  std::map<std::string, std::uint64_t> events_;  // counts by kind, over all runs
  Condition free_;
  bool measuring_ = false;  // aside; only one measurement at a time
};

}  // namespace lcrig
