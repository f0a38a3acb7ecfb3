// SPDX-License-Identifier: Apache-2.0
#include "events/event_kind.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace lcrig {

namespace {

// lint: table, in the order of the enumerators
constexpr std::array<std::string_view, 59> kWords{
    "step_begin",
    "step_end",
    "state",
    "continues",
    "mark",
    "plan",
    "watch",
    "rest",
    "drift",
    "zero",
    "contact",
    "no_contact",
    "stiffness",
    "gap_stated",
    "motion",
    "overshoot",
    "overshoot_exceeded",
    "settings",
    "level_abandoned",
    "repeat",
    "skipped",
    "prompt",
    "confirm",
    "request",
    "pause",
    "resume",
    "abort",
    "freeze",
    "limit",
    "fault",
    "loss",
    "reconnected",
    "refused",
    "contradiction",
    "hands_off",
    "stopped",
    "stop_failed",
    "loaded",
    "retry",
    "repeated",
    "late",
    "late_answer",
    "late_samples",
    "gap",
    "garbled",
    "repeated_samples",
    "clock_step",
    "device_clock_frozen",
    "device_clock_rate",
    "device_clock_jump",
    "device_origin",
    "device_watchdog",
    "device_estop",
    "device_drive_off",
    "device_drive_fault",
    "device_shield",
    "motion_fault",
    "lag",
    "injected",
};
static_assert(kWords.size() == static_cast<std::size_t>(EventKind::other));

}  // namespace

std::string_view to_string(EventKind kind) {
  return kind == EventKind::other ? "other" : kWords[static_cast<std::size_t>(kind)];
}

std::vector<EventKind> all_event_kinds() {
  std::vector<EventKind> out;
  for (std::size_t i = 0; i < kWords.size(); ++i) out.push_back(static_cast<EventKind>(i));
  return out;
}

EventName::EventName(std::string word)
    : kind_(static_cast<EventKind>(std::ranges::find(kWords, word) - kWords.begin())),
      word_(std::move(word)) {}

}  // namespace lcrig
