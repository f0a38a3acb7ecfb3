// SPDX-License-Identifier: Apache-2.0
// What the queue needs from the daemon: plans on its rig, and the execution of runs. Owned by App;
// called by QueueRunner, which it owns.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>
#include <string>

#include "daemon/app/rig_use.hpp"
#include "daemon/queue/hazard.hpp"
#include "daemon/queue/host.hpp"
#include "daemon/queue/plans.hpp"

namespace lcrig {

class Callers;
class News;
class QueueRunner;
class RunStarter;
class Session;
struct Plan;
struct PreparedRun;
struct RunEvent;

class QueueTurns final : public QueueHost {
 public:
  // References to App's members; all must outlive it.
  struct Parts {
    const std::string& database;
    const std::string& vfs;
    RigUse& use;
    RunStarter& starter;
    QueuePlans& plans;
    Callers& callers;
    News& news;
  };
  QueueTurns(asio::any_io_executor executor, Clock& clock, const Parts& parts);
  ~QueueTurns() override;

  // Call when the database is open. Before that there is no queue; a rehearsal of a single run
  // never has one.
  Result<> open();
  QueueRunner* runner() const { return runner_.get(); }
  Task<> run();  // until the runner has ended
  bool goes() const;
  bool over() const;
  // Claims the rig for a person. Errors: busy, with `if_it_goes`, because a queue that goes lets
  // nobody else use the rig.
  Task<Result<>> claim_for_person(RigUse::State state, std::string if_it_goes);
  // Call when the use of the rig has changed.
  void wake();
  // Takes an event of any run, whoever asked for it.
  void note(const RunEvent& event);
  // Checked by RunStarter before a run begins: refuses to command other instruments than those of
  // the queue's earlier runs.
  Result<> may_begin(const Session& session);

  bool is_running() const override { return parts_.use.is_for_run(); }
  Task<Result<EntryPlan>> plan_entry(RunRequest& run, PlanOn on) override;
  Task<TurnEnd> take_turn(TurnOfQueue turn) override;
  double left_s() const override;
  void forget_identities() override;
  Task<std::string> name_of(const PeerCredentials& peer) override;
  void queue_changed(const QueueStatus& status) override;

 private:
  Task<Result<Plan>> plan_on_rig(const RunRequest& run, const PreparedRun& prepared, PlanOn on);
  Task<Result<PreparedRun>> prepare(TurnOfQueue turn);

  asio::any_io_executor executor_;
  Clock& clock_;
  Parts parts_;
  std::unique_ptr<QueueRunner> runner_;
  KnownIdentities identities_;
  HazardWatch hazards_;  // of the current run
};

}  // namespace lcrig
