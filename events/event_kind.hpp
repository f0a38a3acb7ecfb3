// SPDX-License-Identifier: Apache-2.0
// The kinds of event rows that a run writes. The run, the drivers and the daemon write them. The
// analysis, the command line and a continued run read them. docs/events.md lists each kind with its
// payload.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "base/enum_words.hpp"

namespace lcrig {

// All kinds. Their names are the stored words, which are a format: never rename one. `other` is a
// word that the frame chose, or one that this version does not know.
#define LCRIG_EVENT_KINDS                                                                          \
  step_begin, step_end, state, continues, mark, plan, watch, watch_setup, watch_input, rest,       \
      drift, zero, contact, no_contact, stiffness, gap_stated, motion, overshoot,                  \
      overshoot_exceeded, settings, read_back, unproven, level_abandoned, repeat, skipped, prompt, \
      confirm, answer, request, pause, resume, abort, stop_after, pause_at, freeze, limit, fault,  \
      loss, reconnected, refused, contradiction, hands_off, stopped, stop_failed, loaded, retry,   \
      repeated, late, late_answer, late_samples, gap, garbled, repeated_samples, clock_step,       \
      device_clock_frozen, device_clock_rate, device_clock_jump, device_travel_step,               \
      device_force_step, device_origin, device_watchdog, device_estop, device_drive_off,           \
      device_drive_fault, device_shield, device_extrapolated, motion_fault, lag, database_locked,  \
      database_moved, extrapolated, injected, other
enum class EventKind { LCRIG_EVENT_KINDS };
#define LCRIG_TEXT_OF(...) #__VA_ARGS__
#define LCRIG_TEXT(...) LCRIG_TEXT_OF(__VA_ARGS__)
template <>
inline constexpr auto kWordsOf<EventKind> = [] {
  EnumWords<static_cast<std::size_t>(EventKind::other) + 1> words;
  std::string_view rest = LCRIG_TEXT(LCRIG_EVENT_KINDS);
  for (std::string_view& word : words) {
    word = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(word.size() + 2, rest.size()));  // with the ", " behind the word
  }
  return words;
}();
#undef LCRIG_TEXT
#undef LCRIG_TEXT_OF
#undef LCRIG_EVENT_KINDS

// Kinds that only `lcrig watch replay` reads: stored, but neither shown nor exported. The same as a
// condition in SQL.
constexpr bool is_for_replay(EventKind kind) {
  return kind == EventKind::watch_setup || kind == EventKind::watch_input;
}
inline constexpr const char* kIsShown = "kind NOT IN ('watch_setup', 'watch_input')";

// A kind with its stored word. Only the word distinguishes the events of kind `other`.
class EventName {
 public:
  EventName(EventKind kind) : kind_(kind), word_(to_string(kind)) {}
  explicit EventName(std::string word)
      : kind_(parse_word<EventKind>(word).value_or(EventKind::other)), word_(std::move(word)) {}

  EventKind kind() const { return kind_; }
  const std::string& word() const { return word_; }
  bool operator==(EventKind kind) const { return kind_ == kind; }

 private:
  EventKind kind_;
  std::string word_;
};

}  // namespace lcrig
