// SPDX-License-Identifier: Apache-2.0
// Rewords what CLI11 refuses as a person would say it, and says what to type next. Used by the
// programs without subcommands: lcrigd and lcrig-sim.
#pragma once

#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace lcrig {

// "lcrigd: unknown option --confg; did you mean '--config'?", and a line that points to the help.
std::string usage_error(const CLI::App& app, const CLI::ParseError& error);

// Prints the answer to --help, to --version or to a mistake of the command line, and returns the
// exit status of the program. An answer that cannot be written is a failure.
int answer_parse(const CLI::App& app, const CLI::ParseError& error);
// 0 if everything printed was written; else 1, with a message on standard error.
int end_of_output(const CLI::App& app);

}  // namespace lcrig
