// SPDX-License-Identifier: Apache-2.0
// What the queue uses of the daemon: a rig to plan on, runs, and the names of users. App implements
// it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/task.hpp"
#include "daemon/control/queue_handler.hpp"
#include "daemon/queue/hazard.hpp"

namespace lcrig {

// A queued run that may begin now.
struct TurnOfQueue {
  std::int64_t entry = 0;
  RunRequest run;
  std::optional<std::int64_t> resumes_run;
  bool compares = true;  // compare the capacitance on the rig with that of the specimen
};

// How the run ended. `outcome` is an error when it was refused before any command.
struct TurnEnd {
  Result<RunOutcome> outcome;
  std::optional<Hazard> hazard;
  // Set when it did not begin because the specimen on the rig seems to be another one; in words.
  std::optional<std::string> stranger;
};

// What the plan of an entry is based on. The rig is asked only while nothing else uses it.
enum class PlanOn {
  rig,
  as_seen,  // its last answer; without one it is asked
  nothing  // it has just failed to answer, so the request is only checked
};

class QueueHost {
 public:
  virtual ~QueueHost() = default;
  virtual bool is_running() const = 0;  // a run goes on or is being prepared
  // Fills in missing texts and the name in the protocol, and plans as far as the rig is known.
  // Errors: reasons for which a run would be refused.
  virtual Task<Result<EntryPlan>> plan_entry(RunRequest& run, PlanOn on) = 0;
  // Carries out the run, from its preparation to its closed row.
  virtual Task<TurnEnd> take_turn(TurnOfQueue turn) = 0;
  virtual double left_s() const = 0;  // planned time left of the current run; 0: there is none
  // At the next run, accepts whatever instruments answer.
  virtual void forget_identities() = 0;
  virtual Task<std::string> name_of(const PeerCredentials& peer) = 0;
  virtual void queue_changed(const QueueStatus& status) = 0;
};

}  // namespace lcrig
