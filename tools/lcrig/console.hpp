// SPDX-License-Identifier: Apache-2.0
// The streams that all commands write to. Results go to `out`, everything else to `err`. Escape
// codes are sent to terminals only.
#pragma once

#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>

#include "base/name_rule.hpp"
#include "tools/lcrig/exit_code.hpp"
#include "tools/lcrig/process_env.hpp"

namespace lcrig::cli {

// Most characters of a foreign text that are shown to a person (`printable`); of a name it is
// kLongestName. --json and files contain the whole text.
inline constexpr std::size_t kLongestWords = 1000;

struct Console {
  Console(std::ostream& o, std::ostream& e) : out(o), err(e) {}
  std::ostream& out;
  std::ostream& err;
  bool in_tty = false;  // a person can type
  bool err_tty = false;  // a line can be rewritten
  bool out_tty = false;  // `out` is a terminal: files are printed without escape codes
  bool color = false;
  std::function<int()> width;  // columns of the terminal behind `err`
  // Waits until a person has typed a line. nullopt: there will never be one.
  std::function<std::optional<std::string>()> enter;

  void print(const Failure& failure);
  void note(std::string_view words);  // a remark for the person, one line on `err`
  void next(std::string_view command);  // proposes the next command
  // Asks a person at a terminal for a line. nullopt: the terminal is gone.
  std::optional<std::string> wait_for_line(std::string_view words);
  // Prints a file on `out`: byte by byte, unless a terminal would obey some of the bytes.
  void print_file(std::string_view text);
};

// stdin, stdout and stderr of this process. NO_COLOR and TERM=dumb are respected.
Console real_console(const ProcessEnv& env);

}  // namespace lcrig::cli
