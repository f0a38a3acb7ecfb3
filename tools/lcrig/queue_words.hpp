// SPDX-License-Identifier: Apache-2.0
// The queue at a glance, for people: `lcrig status` and `lcrig queue list`.
#pragma once

#include <ostream>
#include <string>

#include "daemon/control/messages.hpp"
#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

void print_queue(std::ostream& out, const QueueStatus& queue);
// What to type now; empty: nothing.
std::string next_for_queue(const GlobalOptions& global, const QueueStatus& queue);

}  // namespace lcrig::cli
