// SPDX-License-Identifier: Apache-2.0
// Makes a run of a request: reads its files, opens the instruments, plans, begins, and keeps the
// session until the run has ended. Requests of people and the queue begin runs here.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/app/news.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/queue/plans.hpp"
#include "daemon/rig/known.hpp"

namespace lcrig {

class RunStarter {
 public:
  // What App shares with it; all outlive it.
  struct Parts {
    const std::string& database;
    const std::unique_ptr<Recorder>& recorder;
    InstrumentFactory& rig;
    KnownRig& known;
    RigUse& use;
    QueuePlans& plans;
    const News& news;
  };
  RunStarter(asio::any_io_executor executor, Clock& clock, const Parts& parts);
  // Asked before anything is commanded, and again before the run row is written: an error ends the
  // start.
  void set_guard(std::function<Result<>(const Session&)> guard) { guard_ = std::move(guard); }

  // Fills in texts that clients do not send. It reads the database: not on the thread of the
  // instruments. Errors: invalid_request.
  Result<> find_texts(RunRequest& wanted) const;
  Task<Result<PreparedRun>> read(RunRequest request);
  // Claims the rig, looks at it and plans; the frame is not commanded.
  Task<Result<Plan>> plan(RunRequest request);
  // The rig was claimed for it. Returns when the run goes on by itself.
  Task<Result<RunStarted>> start(Result<PreparedRun> prepared);

  // The last start failed because what is on the rig does not seem to be the specimen; in words.
  void forget_stranger() { stranger_.reset(); }
  const std::optional<std::string>& stranger() const { return stranger_; }

  // After a start of the daemon: which runs can be continued.
  void look_for_resumable();
  const std::vector<ResumableRun>& resumable() const { return resumable_; }

 private:
  Task<Result<Plan>> preview(RunRequest request);
  Task<Result<>> make_session(PreparedRun prepared, LearnedBy why);
  Session::Listener listener();
  Task<Result<RunStarted>> open(PreparedRun prepared);
  Task<> run_to_its_end();

  asio::any_io_executor executor_;
  Clock& clock_;
  Parts parts_;
  std::function<Result<>(const Session&)> guard_;
  std::optional<std::string> stranger_;
  std::vector<ResumableRun> resumable_;
};

}  // namespace lcrig
