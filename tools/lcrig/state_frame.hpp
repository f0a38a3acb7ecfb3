// SPDX-License-Identifier: Apache-2.0
// What a person states about the frame, because its gateway does not: `lcrig doctor` asks for it
// and writes it into the daemon's config file (docs/config-file.md).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/lcrig/command.hpp"
#include "tools/lcrig/doctor.hpp"

namespace lcrig::cli {

// A key below `frame`, such as "travel_step_um" or "force_loop.lag_s".
struct FrameStatement {
  FrameStatement(std::string k, double v) : key(std::move(k)), value(v) {}
  std::string key;
  double value;
};
using FrameStatements = std::vector<FrameStatement>;

// Parses the KEY=VALUE of every --state. Failure: usage.
Outcome<FrameStatements> parse_statements(const std::vector<std::string>& words);
// Asks a person at the terminal for what `unstated` names (InstrumentState::unstated). What gets an
// empty answer is left out.
FrameStatements ask_for_statements(Console& console, const std::vector<std::string>& unstated);
// The lines for the object `frame` of a config file. Failure: usage, a force loop is not whole.
Outcome<std::string> lines_of(const FrameStatements& statements);
// The text of a config file with these lines; everything else in it stays. Failure: it has no
// object `frame`.
Outcome<std::string> with_lines(std::string_view text, const std::string& name,
                                std::string_view lines);
// `unstated` without the keys that this config file states.
std::vector<std::string> without_stated(const Context& context, const std::string& file,
                                        std::vector<std::string> unstated);
// Writes them into the file, if the file is then in order. The finding says what was written, or
// the lines that a person has to add.
Finding state_in_file(const Context& context, const std::string& file,
                      const FrameStatements& statements);

}  // namespace lcrig::cli
