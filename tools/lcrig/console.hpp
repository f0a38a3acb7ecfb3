// SPDX-License-Identifier: Apache-2.0
// Results go to `out`, everything else to `err`. No escape code leaves for anything but a terminal.
#pragma once

#include <functional>
#include <ostream>

#include "tools/lcrig/exit_code.hpp"
#include "tools/lcrig/process_env.hpp"

namespace lcrig::cli {

struct Console {
  Console(std::ostream& o, std::ostream& e) : out(o), err(e) {}
  std::ostream& out;
  std::ostream& err;
  bool in_tty = false;  // a person can type
  bool err_tty = false;  // a line can be rewritten
  bool color = false;
  std::function<int()> width;  // columns of the terminal behind `err`

  void print(const Failure& failure);
};

// stdin, stdout and stderr of this process; NO_COLOR and TERM=dumb are obeyed.
Console real_console(const ProcessEnv& env);

}  // namespace lcrig::cli
