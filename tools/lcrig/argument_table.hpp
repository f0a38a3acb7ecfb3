// SPDX-License-Identifier: Apache-2.0
// The arguments of all commands as data, and the two texts that are made of them: the part of the
// manual page that cannot differ from the program, and the proposals of completion.
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

// Every command with its options, as scdoc source (docs/man/lcrig.1.scd): `lcrig __man`, for the
// build.
std::string manual_of_commands();

// Proposes words for the place of the cursor: `lcrig __complete -- WORD...`, for the shells'
// completions in tools/completion/. Never fails loudly: files and databases that cannot be read
// have no names. `words`: what was typed behind `lcrig`; the last one is the one to complete, and
// may be empty. The first line says which files may stand there as well: "none", "file", "json" or
// "dir". Each other line is a whole word, a tab, and what it is.
std::string complete(const ProcessEnv& env, const std::vector<std::string>& words);

}  // namespace lcrig::cli
