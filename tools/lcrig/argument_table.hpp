// SPDX-License-Identifier: Apache-2.0
// The arguments of all commands as data. Two texts are made from them, for manual.cpp and
// complete.cpp: that part of the manual page which must agree with the program, and the proposals
// of the shells' completion.
#pragma once

#include <string>
#include <vector>

#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

struct Argument {
  std::vector<std::string> names;  // "-p", "--parameter"; for a positional word "RUN"
  std::string value;  // placeholder of its value: "FILE", "a|b"; empty: a flag
  std::string help;
  Proposes proposes = Proposes::nothing;
  std::vector<std::string> choices;  // permitted values; empty: any
  bool option = true, required = false, repeats = false;
};

std::vector<Argument> arguments_of(Command& command);
std::vector<Argument> global_arguments();

// Every command with its options, as scdoc source for docs/man/lcrig.1.scd. The build calls `lcrig
// __man`.
std::string manual_of_commands();

// Proposes words at the cursor. The shells' completions in tools/completion/ call `lcrig __complete
// -- WORD...`. It never fails with a message; files and databases that cannot be read contribute no
// names. `words` is what was typed behind `lcrig`; the last one is to be completed and may be
// empty. The first line of the result says which files may stand there as well: "none", "file",
// "json" or "dir". Each further line is a whole word, a tab, and what the word is.
std::string complete(const ProcessEnv& env, const std::vector<std::string>& words);

}  // namespace lcrig::cli
