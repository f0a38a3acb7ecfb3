// SPDX-License-Identifier: Apache-2.0
// Plans of entries: the rig as it was seen last, for what is queued while a run goes on, and the
// plans that were made, for a queue that repeats the same run a thousand times.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "daemon/control/queue_handler.hpp"
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

  // Of a request with all its texts.
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

EntryPlan entry_plan(const Plan& plan, bool moves);
// The rig could not be asked: an entry is queued without a plan, and planned before it begins.
bool is_no_refusal(Errc code);

}  // namespace lcrig
