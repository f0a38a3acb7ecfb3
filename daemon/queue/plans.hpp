// SPDX-License-Identifier: Apache-2.0
// What the queue remembers about the rig. QueuePlans: the rig as last seen, to plan during a run,
// and the plans made, because a queue may repeat the same run a thousand times; owned by App.
// KnownIdentities: the instruments of the queue's earlier runs; owned by QueueTurns.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "daemon/control/queue_handler.hpp"
#include "drivers/lcr_meter.hpp"
#include "protocols/plan/check.hpp"

namespace lcrig {

struct Plan;

class QueuePlans {
 public:
  // A rod with weights is another rig than the frame, and is kept apart.
  void see(Rig rig, bool with_weights);
  const std::optional<Rig>& last_rig(bool with_weights) const {
    return with_weights ? rod_ : frame_;
  }

  // `run` must contain the texts of its protocol and its specimen.
  std::optional<EntryPlan> find(const RunRequest& run) const;
  void keep(const RunRequest& run, const EntryPlan& plan);
  void forget() { plans_.clear(); }
  void forget_rigs() {
    frame_.reset();
    rod_.reset();
    plans_.clear();
  }

 private:
  std::optional<Rig> frame_, rod_;
  std::map<std::string, EntryPlan> plans_;
};

// Remembers which instruments answered at the first run after a person started the queue. Each
// later run is compared with them: without a person's consent no other instrument is commanded.
class KnownIdentities {
 public:
  // Errors: refused, saying who answered instead. `rod`: a rod with weights is used, which is
  // another instrument than the frame.
  Result<> compare(const Identity& meter, const Identity& frame, bool rod);

 private:
  std::optional<Identity> meter_, frame_, rod_;
};

EntryPlan entry_plan(const Plan& plan, bool moves);
// The rig could not be asked: the entry is queued without a plan, and planned before it begins.
bool is_no_refusal(Errc code);

}  // namespace lcrig
