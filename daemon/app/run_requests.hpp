// SPDX-License-Identifier: Apache-2.0
// Requests of people that begin a run, continue one, or look at the rig before one. Owned by App;
// called by the control socket.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <string>

#include "daemon/control/handler.hpp"

namespace lcrig {

class Callers;
class DatabaseWrites;
class InstrumentFactory;
class QueueTurns;
class RigUse;
class RunStarter;

class RunRequests final : public RunHandler {
 public:
  // References to App's members; all must outlive it.
  struct Parts {
    const std::string& database;
    InstrumentFactory& rig;
    RigUse& use;
    Callers& callers;
    DatabaseWrites& writes;
    RunStarter& starter;
    QueueTurns& queue;
  };
  RunRequests(asio::any_io_executor executor, Clock& clock, const Parts& parts)
      : executor_(std::move(executor)), clock_(clock), parts_(parts) {}

  Task<Result<RunStarted>> start_run(RunRequest request, PeerCredentials peer) override;
  Task<Result<RunStarted>> resume(std::optional<std::int64_t> run, bool confirmed,
                                  PeerCredentials peer) override;
  Task<Result<Plan>> plan_run(RunRequest request, PeerCredentials peer) override;
  Task<Result<>> ask_instruments(PeerCredentials peer) override;

 private:
  Task<Result<RunStarted>> begin(RunRequest request, PeerCredentials& peer);
  Task<Result<RunStarted>> continue_run(std::int64_t run, bool confirmed, PeerCredentials peer);
  Task<Result<RunStarted>> begin_continuation(std::int64_t run, bool confirmed,
                                              PeerCredentials& peer);
  Task<> tell_refusal(std::string wanted, PeerCredentials peer, Error error);

  asio::any_io_executor executor_;
  Clock& clock_;
  Parts parts_;
};

}  // namespace lcrig
