// SPDX-License-Identifier: Apache-2.0
// The interface by which the queue uses the daemon: a rig to plan on, runs that begin and end,
// names of users. App implements it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/task.hpp"
#include "daemon/control/queue_handler.hpp"
#include "daemon/queue/hazard.hpp"

namespace lcrig {

// A run whose turn it is.
struct TurnOfQueue {
  std::int64_t entry = 0;
  RunRequest run;
  std::optional<std::int64_t> resumes_run;
  bool compares = true;  // what is on the rig with what the specimen should show
};

// The end of a turn. `outcome` is an error when the run was refused before anything was commanded.
struct TurnEnd {
  Result<RunOutcome> outcome;
  std::optional<Hazard> hazard;
  // It did not begin, because what is on the rig does not seem to be its specimen; in words.
  std::optional<std::string> stranger;
};

// Basis of the plan of an entry. The rig is asked only while nothing else uses it.
enum class PlanOn {
  rig,
  as_seen,  // as it answered last; if it did not, it is asked
  nothing  // it did not answer a moment ago: the request is only checked
};

class QueueHost {
 public:
  virtual ~QueueHost() = default;
  virtual bool is_running() const = 0;  // a run goes on, or is prepared
  // Fills in the texts that are missing and the protocol's own name, and plans as far as the rig is
  // known. Errors: what a run would be refused for.
  virtual Task<Result<EntryPlan>> plan_entry(RunRequest& run, PlanOn on) = 0;
  // From its preparation to its closed row.
  virtual Task<TurnEnd> take_turn(TurnOfQueue turn) = 0;
  virtual double left_s() const = 0;  // of the run that goes on, as planned; 0: none does
  // Accepts whatever instruments answer at the next turn.
  virtual void forget_identities() = 0;
  virtual Task<std::string> name_of(const PeerCredentials& peer) = 0;
  virtual void queue_changed(const QueueStatus& status) = 0;
};

}  // namespace lcrig
