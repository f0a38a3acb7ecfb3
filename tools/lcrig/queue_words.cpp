// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/queue_words.hpp"

#include <fmt/ostream.h>

#include "base/text.hpp"
#include "tools/lcrig/command_output.hpp"

namespace lcrig::cli {

namespace {

bool waits_for_a_time(const QueueStatus& q) {
  return q.gate == QueueGate::time;
}

// What has to happen, and by whom: the words of the gate say no more than what.
std::string wait_words(const QueueStatus& q) {
  const auto what = printable(q.prompt, kLongestWords);
  return (waits_for_a_time(q) ? "waits for a time: " : "waits for a person: ") + what;
}

// Whether the first entry may have failed or been interrupted, so that a start needs a choice.
bool may_need_a_choice(const QueueStatus& q) {
  switch (q.cause.value_or(HoldCause::bug)) {
    case HoldCause::not_started:
    case HoldCause::person:
    case HoldCause::empty: return false;
    default: return true;
  }
}

}  // namespace

bool is_in_use(const QueueStatus& q) {
  return q.count > 0 || q.going;
}

std::string idle_words(const std::optional<QueueStatus>& queue, bool correcting) {
  const std::string none = "no run in progress";
  if (correcting) {
    return none + ": the meter's open or short correction is being made: up to two minutes";
  }
  if (!queue || !is_in_use(*queue)) return none;
  const QueueStatus& q = *queue;
  if (!q.going) return none + ": the queue is held: " + printable(q.why, kLongestWords);
  if (!q.prompt.empty()) return none + ": the queue " + wait_words(q);
  return none + (q.count > 0 ? ": the queue is about to start the next one" : "");
}

void print_queue(std::ostream& out, const QueueStatus& q) {
  const auto count = q.count == 1 ? std::string("1 entry") : fmt::format("{} entries", q.count);
  if (q.going) {
    fmt::print(out, "the queue goes: {}\n", count);
  } else {
    fmt::print(out, "the queue is held: {}; {}\n", count, printable(q.why, kLongestWords));
  }
  if (!q.prompt.empty()) fmt::print(out, "{}\n", wait_words(q));
  if (!q.locked_by.empty()) fmt::print(out, "locked by {}\n", printable(q.locked_by, kLongestName));
}

std::string next_for_queue(const GlobalOptions& global, const QueueStatus& q,
                           std::optional<EntryState> head) {
  if (waits_for_a_time(q)) return {};
  if (q.gate == QueueGate::person) return next_command(global, {"queue", "answer", "yes"});
  if (!q.prompt.empty()) {
    return next_command(global, {"queue", "answer", "NAME"}, "of what is on the rig");
  }
  if (q.going || q.count == 0) return {};
  if (head == EntryState::failed) {
    return next_command(global, {"queue", "start", "--repeat"}, "or --skip; look at the rig first");
  }
  if (head == EntryState::interrupted) {
    return next_command(global, {"queue", "start", "--resume"},
                        "or --repeat, --skip; look at the rig first");
  }
  if (!head && may_need_a_choice(q)) {
    return next_command(global, {"queue", "list"}, "shows the first entry, and how to start");
  }
  return next_command(global, {"queue", "start"});
}

}  // namespace lcrig::cli
