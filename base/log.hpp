// SPDX-License-Identifier: Apache-2.0
// Logging goes to stderr; under systemd with <N> priority prefixes, which the journal understands.
#pragma once

#include <spdlog/spdlog.h>

#include <string_view>

namespace lcrig {

// Level: trace, debug, info, warn, error, off. Returns false for any other word.
bool set_up_logging(std::string_view level);

// Text from outside (operator notes, instrument replies) made safe for a terminal and one log line:
// control characters become \xNN.
std::string printable(std::string_view text);

}  // namespace lcrig
