// SPDX-License-Identifier: Apache-2.0
// Events and errors of a run after which the queue is held until a person has looked at the rig,
// whatever a batch says. App collects them; the queue decides by them (decide.hpp).
#pragma once

#include <optional>
#include <string_view>

#include "base/queue_words.hpp"
#include "base/result.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

// The causes from `not_standing` to `other_instrument`. The worst comes first.
using Hazard = HoldCause;
std::string_view words_of(Hazard hazard);

std::optional<Hazard> hazard_of(const EventName& kind);
std::optional<Hazard> hazard_of(Errc code);

// Remembers the worst hazard of one run, from its events and its end.
class HazardWatch {
 public:
  void take(std::optional<Hazard> hazard);
  std::optional<Hazard> worst() const { return worst_; }

 private:
  std::optional<Hazard> worst_;
};

}  // namespace lcrig
