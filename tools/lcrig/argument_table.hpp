// SPDX-License-Identifier: Apache-2.0
// The arguments of all commands as data, for the manual page and for completion.
#pragma once

#include <string>
#include <vector>

#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

struct Argument {
  std::vector<std::string> names;  // "-p", "--parameter"; of a word without an option "RUN"
  std::string value;  // what stands for its value: "FILE", "a|b"; empty: a flag
  std::string help;
  Proposes proposes = Proposes::nothing;
  std::vector<std::string> choices;  // empty: anything
  bool option = true, required = false, repeats = false;
};

std::vector<Argument> arguments_of(Command& command);
std::vector<Argument> global_arguments();

}  // namespace lcrig::cli
