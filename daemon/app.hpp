// SPDX-License-Identifier: Apache-2.0
// The daemon: makes and connects the parts that serve clients and run protocols (daemon/app/).
// main.cpp makes one on the real clock; rehearse.cpp one in virtual time without a socket.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>
#include <string>

#include "daemon/app/callers.hpp"
#include "daemon/app/config_taker.hpp"
#include "daemon/app/database_writes.hpp"
#include "daemon/app/heartbeat.hpp"
#include "daemon/app/meter_requests.hpp"
#include "daemon/app/metrics_keeper.hpp"
#include "daemon/app/news.hpp"
#include "daemon/app/queue_turns.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/app/rig_watch.hpp"
#include "daemon/app/run_requests.hpp"
#include "daemon/app/run_starter.hpp"
#include "daemon/app/run_steering.hpp"
#include "daemon/config.hpp"
#include "daemon/control/handler.hpp"
#include "daemon/control/server.hpp"
#include "daemon/queue/plans.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/rig/known.hpp"
#include "daemon/rig/operator.hpp"
#include "daemon/service.hpp"

namespace lcrig {

class Recorder;
struct PreparedRun;

// The parts in which a rehearsal differs from a daemon.
struct AppParts {
  ConfigTaker::Load load_config;
  std::unique_ptr<InstrumentFactory> rig;  // empty: as the config file says
  std::string vfs;  // SQLite's VFS for the database; empty: the operating system's
  ServiceNotifier notifier;
  bool sync_each_commit = true;  // Recorder::Options
  const Clock* true_clock = nullptr;  // the same; it must outlive App
  ControlOptions control;
};

// Must outlive the coroutines of its parts: destroy it only after `shut_down` has returned and none
// of them is left to run.
class App final : public ControlHandler {
 public:
  App(asio::io_context& io, Clock& clock, Config config, AppParts parts = AppParts());
  ~App() override;

  // Opens the database and closes orphaned runs. Call it before `run_through`.
  Result<> open();
  // `open`, and the queue of the database without a socket, for the rehearsal of a batch.
  Result<> open_with_queue();
  // `open`, then listens at the socket and tells systemd. From now on the meter is asked regularly.
  // Errors: those of the parts.
  Result<> start();
  // For SIGTERM and SIGINT: stops the run (abort, then `finally`) and closes everything. A second
  // call during the first changes nothing. False: a thread still computes the finite elements of a
  // simulated specimen, and the process has to end without it.
  Task<bool> shut_down(std::string why);
  // Carries out one run without a socket. May be called once.
  Task<Result<RunOutcome>> run_through(PreparedRun prepared);

  // For a process that ends because of a bug: writes the wire logs to disk, if the disk answers.
  void save_wire_logs() { rig_->finish_wire_logs(std::chrono::seconds(2)); }

  RigWatch& rig_watch() { return watch_; }  // call it before `start`
  ConfigTaker& config_taker() { return config_taker_; }  // for SIGHUP
  const ControlServer& control() const { return control_; }

  RunHandler& runs() override { return requests_; }
  SteeringHandler& steering() override { return steering_; }
  StoreHandler& store() override { return writes_; }
  MeterHandler& meter() override { return meter_; }
  QueueHandler* queue() override;
  DaemonStatus status() const override;
  ConfigView config_view() const override { return config_taker_.view(); }
  Task<Result<std::string>> metrics() override { return metrics_.text(); }

 private:
  void connect();

  asio::any_io_executor executor_;
  asio::io_context& io_;
  Clock& clock_;
  Config config_;
  std::string vfs_;
  bool sync_each_commit_;
  const Clock* true_clock_;
  ServiceNotifier notifier_;
  RemoteOperator person_;
  KnownRig known_;
  std::unique_ptr<InstrumentFactory> rig_;
  std::unique_ptr<Recorder> recorder_;  // nullptr: no database is open
  ControlServer control_;
  RigUse use_;
  QueuePlans plans_;
  Callers callers_;
  DatabaseWrites writes_;
  News news_;
  RunStarter starter_;
  QueueTurns queue_;
  RunRequests requests_;
  MeterRequests meter_;
  RunSteering steering_;
  RigWatch watch_;
  Heartbeat heartbeat_;
  MetricsKeeper metrics_;
  ConfigTaker config_taker_;
};

}  // namespace lcrig
