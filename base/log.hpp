// SPDX-License-Identifier: Apache-2.0
// Set-up of logging to stderr, called by the programs' main(); everybody else includes this header
// to log. Under systemd each line carries the <N> priority prefix that the journal understands.
#pragma once

#include <memory>
#include <string_view>

namespace spdlog {
class formatter;
}

namespace lcrig {

// Level: trace, debug, info, warn, error, off. Returns false for any other word. Every message
// becomes one line of at most 4000 characters, escaped by `printable`.
bool set_up_logging(std::string_view level);
// The format of a log line: for the journal, or with time and level for a terminal.
std::unique_ptr<spdlog::formatter> log_formatter(bool journal);

}  // namespace lcrig
