// SPDX-License-Identifier: Apache-2.0
// What the queue needs of the daemon: plans on its rig, and runs whose turn it is. App owns it;
// QueueRunner, which it owns, calls it.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>
#include <string>

#include "daemon/app/callers.hpp"
#include "daemon/app/news.hpp"
#include "daemon/app/run_starter.hpp"
#include "daemon/queue/host.hpp"
#include "daemon/queue/plans.hpp"
#include "daemon/queue/runner.hpp"

namespace lcrig {

class QueueTurns final : public QueueHost {
 public:
  // What App shares with it; all outlive it.
  struct Parts {
    const std::string& database;
    const std::string& vfs;
    RigUse& use;
    RunStarter& starter;
    QueuePlans& plans;
    Callers& callers;
    const News& news;
  };
  QueueTurns(asio::any_io_executor executor, Clock& clock, const Parts& parts)
      : executor_(std::move(executor)), clock_(clock), parts_(parts) {}

  // The database is open. Until then there is no queue, and a rehearsal of one run has none.
  Result<> open();
  QueueRunner* runner() const { return runner_.get(); }
  Task<> run();  // until the runner ended
  bool goes() const { return runner_ && runner_->goes(); }
  bool over() const { return !runner_ || runner_->over(); }
  // Claims the rig for a person. A queue that goes leaves it to nobody: busy, with `if_it_goes`.
  Task<Result<>> claim_for_person(RigUse::State state, std::string if_it_goes);
  // The use of the rig is another one.
  void wake() {
    if (goes()) runner_->wake();
  }
  // An event of a run, whoever asked for it.
  void note(const RunEvent& event) { hazards_.take(hazard_of(event.kind)); }
  // Guard of RunStarter: a turn commands no other instruments than the turns before it.
  Result<> may_begin(const Session& session);

  bool is_running() const override { return parts_.use.is_for_run(); }
  Task<Result<EntryPlan>> plan_entry(RunRequest& run, PlanOn on) override;
  Task<TurnEnd> take_turn(TurnOfQueue turn) override;
  double left_s() const override;
  void forget_identities() override;
  Task<std::string> name_of(const PeerCredentials& peer) override {
    return parts_.callers.name_of(peer);
  }
  void queue_changed(const QueueStatus& status) override { parts_.news.queue_changed(status); }

 private:
  Task<Result<Plan>> plan_on_rig(const RunRequest& run, const PreparedRun& prepared, PlanOn on);
  Task<Result<PreparedRun>> prepare(TurnOfQueue turn);

  asio::any_io_executor executor_;
  Clock& clock_;
  Parts parts_;
  std::unique_ptr<QueueRunner> runner_;
  KnownIdentities identities_;
  HazardWatch hazards_;  // of the run that goes on
};

}  // namespace lcrig
