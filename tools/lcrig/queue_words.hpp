// SPDX-License-Identifier: Apache-2.0
// A summary of the queue for people: for `lcrig status`, `lcrig watch` and `lcrig queue list`.
#pragma once

#include <optional>
#include <ostream>
#include <string>

#include "daemon/control/messages.hpp"
#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

void print_queue(std::ostream& out, const QueueStatus& queue);
// Whether there is something to say about it.
bool is_in_use(const QueueStatus& queue);
// Why no run is in progress, and what the daemon waits for, in one line.
std::string idle_words(const std::optional<QueueStatus>& queue, bool correcting);
// The command to propose; empty: none. `head`: state of the first entry, where it is known.
std::string next_for_queue(const GlobalOptions& global, const QueueStatus& queue,
                           std::optional<EntryState> head = std::nullopt);

}  // namespace lcrig::cli
