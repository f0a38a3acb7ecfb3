// SPDX-License-Identifier: Apache-2.0
#include "base/queue_words.hpp"

#include <cstddef>

namespace lcrig {

std::string_view to_string(EntryState state) {
  constexpr std::string_view kWords[] = {"waiting", "running", "interrupted", "failed",
                                         "done",    "skipped", "removed"};
  return kWords[static_cast<std::size_t>(state)];
}

std::string_view to_string(HoldCause cause) {
  constexpr std::string_view kWords[] = {"not_started",       "person",      "restart",     "empty",
                                         "not_standing",      "left_loaded", "frame_fault", "limit",
                                         "other_instrument",  "aborted",     "failure",     "look",
                                         "too_many_failures", "clock_step",  "bug"};
  return kWords[static_cast<std::size_t>(cause)];
}

std::string_view to_string(QueueGate gate) {
  constexpr std::string_view kWords[] = {"specimen", "probe",  "fixture",
                                         "stranger", "person", "time"};
  return kWords[static_cast<std::size_t>(gate)];
}

std::string_view to_string(HeadChoice choice) {
  constexpr std::string_view kWords[] = {"none", "resume", "repeat", "skip"};
  return kWords[static_cast<std::size_t>(choice)];
}

std::string_view to_string(OnFailure policy) {
  constexpr std::string_view kWords[] = {"hold", "skip", "look", "repeat"};
  return kWords[static_cast<std::size_t>(policy)];
}

std::string_view to_string(BatchOrder order) {
  constexpr std::string_view kWords[] = {"given", "blocks", "random"};
  return kWords[static_cast<std::size_t>(order)];
}

}  // namespace lcrig
