// SPDX-License-Identifier: Apache-2.0
// Turns a request into a run: reads its files, opens the instruments, plans, begins, and keeps the
// session until the run has ended. Requests of people and the queue begin runs here.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "base/task.hpp"
#include "daemon/control/messages.hpp"

namespace lcrig {

class DatabaseWrites;
class InstrumentFactory;
class KnownRig;
class News;
class QueuePlans;
class Recorder;
class RigUse;
class Session;
struct Plan;
struct PreparedRun;

class RunStarter {
 public:
  // References to App's members; all must outlive it.
  struct Parts {
    const std::string& database;
    const std::unique_ptr<Recorder>& recorder;
    InstrumentFactory& rig;
    KnownRig& known;
    RigUse& use;
    QueuePlans& plans;
    News& news;
    DatabaseWrites& writes;
  };
  RunStarter(asio::any_io_executor executor, Clock& clock, const Parts& parts);
  // `guard` is called before anything is commanded, and again before the run row is written. An
  // error ends the start.
  void set_guard(std::function<Result<>(const Session&)> guard) { guard_ = std::move(guard); }

  // Fills in texts that clients do not send. It reads the database, so do not call it on the thread
  // of the instruments. Errors: invalid_request.
  Result<> find_texts(RunRequest& wanted) const;
  Task<Result<PreparedRun>> read(RunRequest request);
  // Claims the rig, looks at it and plans, without commanding the frame.
  Task<Result<Plan>> plan(RunRequest request);
  // The caller has claimed the rig. Returns when the run goes on by itself.
  Task<Result<RunStarted>> start(Result<PreparedRun> prepared);

  // Words when the last start failed because the specimen on the rig does not seem to be the
  // requested one.
  void forget_stranger() { stranger_.reset(); }
  const std::optional<std::string>& stranger() const { return stranger_; }

  // Finds the runs that can be continued, after the daemon has started.
  void look_for_resumable();
  const std::vector<ResumableRun>& resumable() const { return resumable_; }

 private:
  Task<Result<Plan>> preview(RunRequest request);
  Task<Result<>> make_session(PreparedRun prepared, LearnedBy why);
  void listen_to(Session& session);
  Task<Result<RunStarted>> open(PreparedRun prepared);
  Task<> run_to_its_end();
  Task<> stop_until_it_stands(RunOutcome ended);

  asio::any_io_executor executor_;
  Clock& clock_;
  Parts parts_;
  std::function<Result<>(const Session&)> guard_;
  std::optional<std::string> stranger_;
  std::vector<ResumableRun> resumable_;
};

}  // namespace lcrig
