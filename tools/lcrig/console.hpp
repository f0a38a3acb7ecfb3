// SPDX-License-Identifier: Apache-2.0
// The streams that all commands write to: results go to `out`, everything else to `err`. No escape
// code leaves for anything but a terminal.
#pragma once

#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>

#include "tools/lcrig/exit_code.hpp"
#include "tools/lcrig/process_env.hpp"

namespace lcrig::cli {

// How much of a text from outside a person gets to see at once, characters (`printable`); --json
// and files have all of it.
inline constexpr std::size_t kLongestName = 60, kLongestWords = 1000;

struct Console {
  Console(std::ostream& o, std::ostream& e) : out(o), err(e) {}
  std::ostream& out;
  std::ostream& err;
  bool in_tty = false;  // a person can type
  bool err_tty = false;  // a line can be rewritten
  bool out_tty = false;  // a terminal shows `out`: a file goes there without escape codes
  bool color = false;
  std::function<int()> width;  // columns of the terminal behind `err`
  // Waits until a person typed a line; nullopt: nobody ever will.
  std::function<std::optional<std::string>()> enter;

  void print(const Failure& failure);
  void note(std::string_view words);  // what a person may want to know; one line of `err`
  void next(std::string_view command);  // what to type now
  // Asks a person at a terminal for a line. nullopt: the terminal is gone.
  std::optional<std::string> wait_for_line(std::string_view words);
  // A file to `out`: byte by byte, unless a terminal would obey some of them.
  void print_file(std::string_view text);
};

// stdin, stdout and stderr of this process; NO_COLOR and TERM=dumb are obeyed.
Console real_console(const ProcessEnv& env);

}  // namespace lcrig::cli
