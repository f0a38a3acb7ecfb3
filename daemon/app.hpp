// SPDX-License-Identifier: Apache-2.0
// The daemon: owns recorder, control socket and the instruments of the run that is going on.
// main.cpp makes one on the real clock, rehearse.cpp one in virtual time and without a socket.
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/condition.hpp"
#include "daemon/config.hpp"
#include "daemon/config_reload.hpp"
#include "daemon/control/handler.hpp"
#include "daemon/control/server.hpp"
#include "daemon/liveness.hpp"
#include "daemon/queue/host.hpp"
#include "daemon/queue/identities.hpp"
#include "daemon/queue/plans.hpp"
#include "daemon/queue/runner.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/rig/corrector.hpp"
#include "daemon/rig/known.hpp"
#include "daemon/rig/operator.hpp"
#include "daemon/rig/real.hpp"
#include "daemon/service.hpp"
#include "daemon/session.hpp"

namespace lcrig {

// Parts in which a rehearsal differs from a daemon.
struct AppParts {
  // Reads and checks the config file again; on a thread of its own. Empty: there is none.
  std::function<Result<Config>()> load_config;
  std::unique_ptr<InstrumentFactory> rig;  // empty: that of the config file
  std::string vfs;  // of SQLite, for the database; empty: the operating system's
  ServiceNotifier notifier;
  bool sync_each_commit = true;  // Recorder::Options
  ControlOptions control;
};

class App final : public ControlHandler, public QueueHost {
 public:
  App(asio::io_context& io, Clock& clock, Config config, AppParts parts = AppParts());
  ~App() override;

  // Opens the database and closes orphaned runs, for `run_through`.
  Result<> open();
  // `open`, and the queue of the database with nobody at a socket, for a rehearsal of a batch.
  Result<> open_with_queue();
  // `open`, socket listening, systemd told; from now on the meter is asked now and then. Errors: as
  // the parts say.
  Result<> start();
  // SIGTERM, SIGINT: stops the run (abort, then `finally`), closes everything. A second call while
  // the first is under way changes nothing. False: a thread still reckons the finite elements of a
  // simulated specimen; the process is to end without it.
  Task<bool> shut_down(std::string why);
  // SIGHUP: reads the config file again. A bad one changes nothing, and a run notices nothing. One
  // call after the other.
  Task<> reload();
  // One run to its end, asked for by nobody at a socket. Once.
  Task<Result<RunOutcome>> run_through(PreparedRun prepared);

  // For a process that a bug ends: what was logged of the wires is on the disk, if the disk
  // answers.
  void save_wire_logs();

  // Before `start`, which may wait for a disk or for another program: after a crash in the middle
  // of a run the frame is stopped first.
  bool frame_may_be_left() const;
  Task<> make_frame_safe();

  // Figures of the control socket.
  std::size_t clients() const { return control_->clients(); }
  std::size_t waiting_bytes() const { return control_->waiting_bytes(); }
  std::size_t held_bytes() const { return control_->held_bytes(); }

  Task<Result<RunStarted>> start_run(RunRequest request, PeerCredentials peer) override;
  Task<Result<>> pause(PeerCredentials peer) override;
  Task<Result<StopAnswer>> pause_at(StopPlace place, PeerCredentials peer) override;
  Task<Result<StopAnswer>> stop_after(StopPlace place, std::string why,
                                      PeerCredentials peer) override;
  Task<Result<RunStarted>> resume(std::optional<std::int64_t> run, bool confirmed,
                                  PeerCredentials peer) override;
  Task<Result<StopAnswer>> abort(std::string why, PeerCredentials peer) override;
  Task<Result<StopAnswer>> freeze(std::string why, PeerCredentials peer) override;
  Task<Result<Plan>> plan_run(RunRequest request, PeerCredentials peer) override;
  Task<Result<>> ask_instruments(PeerCredentials peer) override;
  Task<Result<>> confirm(PeerCredentials peer) override;
  Task<Result<Answered>> answer(AnswerRequest request, PeerCredentials peer) override;
  Task<Result<>> note_run(std::int64_t run, std::string text, PeerCredentials peer) override;
  Task<Result<std::vector<std::string>>> tag_run(TagRequest request, PeerCredentials peer) override;
  Task<Result<std::string>> add_specimen(std::string text, PeerCredentials peer) override;
  Task<Result<MeterCorrections>> correct_meter(CorrectionKind kind, PeerCredentials peer) override;
  Task<Result<MeterCorrections>> look_at_corrections(PeerCredentials peer) override;
  Task<Result<std::string>> metrics() override;
  DaemonStatus status() const override;
  ConfigView config_view() const override { return reload_.view(); }
  QueueHandler* queue() override { return queue_.get(); }

 private:
  // The present use of the instruments. Only an idle daemon begins something new.
  enum class Use {
    idle,
    asking,  // who they are, or what a plan needs to know
    correcting,  // the meter
    starting,  // a run is prepared: until its row exists, nothing moves
    running,  // until its row and the ports are closed
  };
  // How long a request waits for the name of who asks. A stop is not held up by a name; 20 ms
  // suffice for one that stands in a file.
  static constexpr Duration kNamePatience = std::chrono::seconds(2);
  static constexpr Duration kNamePatienceOfStops = std::chrono::milliseconds(20);
  void enter(Use use);
  void take_config(Config wanted);
  void config_changed();
  void look_for_resumable();
  // Work for the queue (app_queue.cpp).
  Result<> open_queue();
  Task<> run_queue();
  bool is_running() const override { return use_ == Use::starting || use_ == Use::running; }
  Task<Result<EntryPlan>> plan_entry(RunRequest& run, PlanOn on) override;
  Task<Result<Plan>> plan_on_rig(const RunRequest& run, const PreparedRun& prepared, PlanOn on);
  Task<TurnEnd> take_turn(TurnOfQueue turn) override;
  Task<Result<PreparedRun>> prepare_turn(TurnOfQueue turn);
  Result<> may_begin();
  double left_s() const override;
  void forget_identities() override;
  Task<std::string> name_of(const PeerCredentials& peer) override;
  void queue_changed(const QueueStatus& status) override;
  Result<> leaves_to_queue() const;
  bool is_settled() const { return use_ == Use::idle || use_ == Use::running; }

  Task<Result<>> claim(Use use);
  Task<Result<RunStarted>> continue_run(std::int64_t run, bool confirmed, PeerCredentials peer);
  Task<Result<RunStarted>> begin_run(RunRequest request, PeerCredentials& peer);
  Task<Result<RunStarted>> begin_continuation(std::int64_t run, bool confirmed,
                                              PeerCredentials& peer);
  Task<> tell_refusal(std::string wanted, PeerCredentials peer, Error error);
  Task<Result<RunStarted>> start_claimed(Result<PreparedRun> prepared);
  Task<Result<RunStarted>> open_run(PreparedRun prepared);
  Task<Result<PreparedRun>> read_request(RunRequest request);
  Task<Result<Plan>> preview(RunRequest request);
  Result<> not_stopped() const;
  Result<> find_texts(RunRequest& wanted) const;
  Task<Result<>> make_session(PreparedRun prepared, LearnedBy why);
  Task<> run_to_its_end();
  Task<Result<StopAnswer>> stop_run(Interrupt kind, std::string why, PeerCredentials peer);
  Task<Result<StopAnswer>> ask_at(PlannedStops::Kind kind, StopPlace place, std::string why,
                                  PeerCredentials peer);
  StopAnswer stop_start(Interrupt kind, std::string why);
  Task<Result<StopAnswer>> confirm_stop(Run& run, std::uint64_t stands, std::uint64_t failures);
  Task<std::string> user_name(const PeerCredentials& peer, Duration patience) const;
  void spawn(Task<> task);
  Task<> heartbeat();
  Task<> write_metrics();
  void watch_parts();
  bool is_working();
  void tell_lag(Duration late);
  void tell_service(bool working);
  Task<> probe();
  Task<> watch_ports();
  std::string stored_anchor(std::int64_t run) const;  // empty: there is none
  bool had_ended(std::int64_t orphan) const;  // its end was deleted
  bool left_commanding(std::int64_t run) const;
  Task<> note_runs(std::vector<std::int64_t> runs, std::string text);
  void publish_event(const RunEvent& event);
  void publish();
  Run* live_run() const { return session_ ? session_->run() : nullptr; }

  asio::io_context& io_;
  Clock& clock_;
  Config config_;
  ConfigReload reload_{config_};
  std::function<Result<Config>()> load_config_;
  ServiceNotifier notifier_;
  RemoteOperator person_;
  bool sync_each_commit_;
  ControlOptions control_options_;
  std::string vfs_;
  KnownRig known_;
  RealRig* real_ = nullptr;  // `rig_`, when it is one
  std::unique_ptr<InstrumentFactory> rig_;
  std::unique_ptr<Corrector> corrector_;
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<ControlServer> control_;  // nullptr: nobody listens
  std::unique_ptr<Session> session_;
  std::unique_ptr<QueueRunner> queue_;  // nullptr: a rehearsal of one run has none
  QueuePlans plans_;
  KnownIdentities identities_;  // of the turns of the queue
  HazardWatch hazards_;  // of the run that goes on
  std::optional<std::string> stranger_;  // that the last start met
  Use use_ = Use::idle;
  Condition changed_;  // `use_`, `session_`, `shutting_down_`, or how often the frame was stopped
  std::optional<InterruptRequest> stop_of_start_;  // asked for meanwhile: nothing may move
  bool storing_ = false;  // a specimen or a note, beside the loop
  bool shutting_down_ = false;
  bool frame_to_make_safe_ = false;  // a run that commanded it was cut off by a crash
  bool frame_was_made_safe_ = false;  // before anything else
  Liveness liveness_;
  LoopLag lag_{std::chrono::milliseconds(200)};
  std::map<std::string, std::uint64_t> events_;  // by kind, of all runs
  bool measuring_ = false;  // metrics, beside the loop
  std::vector<std::string> stuck_;
  MonoTime lag_told_;
  std::optional<RunOutcome> last_run_;
  std::vector<ResumableRun> resumable_;
};

}  // namespace lcrig
