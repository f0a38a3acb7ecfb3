// SPDX-License-Identifier: Apache-2.0
// What the queue keeps of the rig. QueuePlans: the rig as it was last seen, to plan on while a run
// goes on, and the plans already made, because a queue may repeat the same run a thousand times;
// App owns it. KnownIdentities: the instruments of the turns before; QueueTurns has it.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "daemon/control/queue_handler.hpp"
#include "drivers/lcr_meter.hpp"
#include "protocols/plan/check.hpp"
#include "protocols/plan/plan.hpp"

namespace lcrig {

class QueuePlans {
 public:
  // A rod with weights is another rig than the frame.
  void see(Rig rig, bool with_weights);
  const std::optional<Rig>& last_rig(bool with_weights) const {
    return with_weights ? rod_ : frame_;
  }

  // `run` has the texts of its protocol and its specimen.
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

// Remembers which instruments answered at the first turn after a person started the queue. Each
// later turn is compared with them: no other instrument is commanded without a person's word.
class KnownIdentities {
 public:
  // Errors: refused; says who answered instead of whom. `rod`: weights stand for the frame, which
  // is another instrument than the frame that moves.
  Result<> compare(const Identity& meter, const Identity& frame, bool rod);

 private:
  std::optional<Identity> meter_, frame_, rod_;
};

EntryPlan entry_plan(const Plan& plan, bool moves);
// The rig could not be asked: an entry is queued without a plan, and planned before it begins.
bool is_no_refusal(Errc code);

}  // namespace lcrig
