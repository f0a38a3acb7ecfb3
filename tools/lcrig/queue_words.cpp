// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/queue_words.hpp"

#include <fmt/ostream.h>

#include "base/text.hpp"
#include "tools/lcrig/command_output.hpp"

namespace lcrig::cli {

void print_queue(std::ostream& out, const QueueStatus& q) {
  const auto count = q.count == 1 ? std::string("1 entry") : fmt::format("{} entries", q.count);
  if (q.going) {
    fmt::print(out, "the queue goes: {}\n", count);
  } else {
    fmt::print(out, "the queue is held: {}; {}\n", count, printable(q.why, kLongestWords));
  }
  if (!q.prompt.empty()) fmt::print(out, "waits for: {}\n", printable(q.prompt, kLongestWords));
  if (!q.locked_by.empty()) fmt::print(out, "locked by {}\n", printable(q.locked_by, kLongestName));
}

std::string next_for_queue(const GlobalOptions& global, const QueueStatus& q,
                           std::optional<EntryState> head) {
  if (q.gate == QueueGate::time) return {};
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
  return next_command(global, {"queue", "start"});
}

}  // namespace lcrig::cli
