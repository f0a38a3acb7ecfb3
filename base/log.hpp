// SPDX-License-Identifier: Apache-2.0
// Logging goes to stderr; under systemd with <N> priority prefixes, which the journal understands.
#pragma once

#include <spdlog/spdlog.h>

#include <memory>
#include <string_view>

#include "base/text.hpp"

namespace lcrig {

// Level: trace, debug, info, warn, error, off. Returns false for any other word. Every message is
// made one harmless line (`printable`) of at most 4000 characters.
bool set_up_logging(std::string_view level);
// How a line of it looks: for the journal, or for a terminal with time and level.
std::unique_ptr<spdlog::formatter> log_formatter(bool journal);

}  // namespace lcrig
