// SPDX-License-Identifier: Apache-2.0
// The daemon: owns recorder, control socket and the rig of the run that is going on.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "daemon/config.hpp"
#include "daemon/control/handler.hpp"
#include "daemon/control/server.hpp"
#include "daemon/liveness.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/service.hpp"
#include "daemon/session.hpp"

namespace lcrig {

class App final : public ControlHandler {
 public:
  App(asio::io_context& io, Clock& clock, Config config);
  ~App() override;

  // Database open, orphaned runs closed, socket listening, systemd told. Errors: as the parts say.
  Result<> start();
  // SIGTERM, SIGINT: stops the run (abort, then `finally`), closes everything. A second call while
  // the first is under way changes nothing. False: a thread still reckons the finite elements of a
  // simulated specimen; the process is to end without it.
  Task<bool> shut_down(std::string why);

  // Of the control socket.
  std::size_t clients() const { return control_->clients(); }
  std::size_t waiting_bytes() const { return control_->waiting_bytes(); }
  std::size_t held_bytes() const { return control_->held_bytes(); }

  Task<Result<RunStarted>> start_run(StartRunRequest request, PeerCredentials peer) override;
  Task<Result<>> pause(PeerCredentials peer) override;
  Task<Result<RunStarted>> resume(std::optional<std::int64_t> run, bool confirmed,
                                  PeerCredentials peer) override;
  Task<Result<StopAnswer>> abort(std::string why, PeerCredentials peer) override;
  Task<Result<StopAnswer>> freeze(std::string why, PeerCredentials peer) override;
  Task<Result<std::string>> plan_run(StartRunRequest request, PeerCredentials peer) override;
  Task<Result<>> ask_instruments(PeerCredentials peer) override;
  Task<Result<>> confirm(PeerCredentials peer) override;
  Task<Result<std::string>> add_specimen(std::string text, PeerCredentials peer) override;
  DaemonStatus status() const override;

 private:
  Task<Result<RunStarted>> prepare_and_start(StartRunRequest request);
  Task<Result<RunStarted>> continue_run(std::int64_t run, bool confirmed, PeerCredentials peer);
  Task<Result<RunStarted>> prepare_and_continue(std::int64_t run, bool confirmed, std::string user);
  Task<Result<RunStarted>> start_prepared(PreparedRun prepared);
  Task<Result<PreparedRun>> read_request(StartRunRequest request);
  Task<Result<std::string>> preview(StartRunRequest request);
  Result<> not_stopped() const;
  Task<Result<>> claim_start();
  Result<> find_text(SessionRequest& wanted) const;
  Task<Result<std::unique_ptr<Instruments>>> open_instruments(const PreparedRun& prepared);
  Task<> run_to_its_end();
  Task<Result<StopAnswer>> stop_run(Interrupt kind, std::string why, const PeerCredentials& peer);
  StopAnswer stop_start(Interrupt kind, std::string why);
  Task<Result<StopAnswer>> confirm_stop(Run& run, std::uint64_t stands, std::uint64_t failures);
  void spawn(Task<> task);
  Task<> heartbeat();
  void watch_parts();
  bool is_working();
  void tell_lag(Duration late);
  void name_instruments();
  Task<> probe();
  Task<> probe_meter();
  Task<> make_frame_safe();
  Task<> look_at_frame();
  bool left_commanding(std::int64_t run) const;
  void note_interrupted(const std::string& text);
  void publish_event(const RunEvent& event);
  void publish();
  Run* live_run() const;

  asio::io_context& io_;
  Clock& clock_;
  Config config_;
  ServiceNotifier notifier_;
  RemoteOperator person_;
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<ControlServer> control_;
  std::unique_ptr<Session> session_;
  bool preparing_ = false;  // between start_run and the run row, or while probing
  bool starting_ = false;  // of it: a run
  std::optional<InterruptRequest> stop_of_start_;  // asked for meanwhile: nothing may move
  bool building_world_ = false;  // the simulated one, beside the loop
  bool adding_ = false;  // a specimen
  Liveness liveness_;
  std::vector<std::string> stuck_;
  MonoTime lag_told_;
  InstrumentState meter_state_, frame_state_;
  bool shutting_down_ = false;
  bool frame_to_make_safe_ = false;  // a run that commanded it was cut off by a crash
  std::optional<RunEnded> last_run_;
};

}  // namespace lcrig
