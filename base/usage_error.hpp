// SPDX-License-Identifier: Apache-2.0
// Words for what CLI11 refuses, as a person would say them, with what to type next. For programs
// without subcommands: lcrigd and lcrig-sim.
#pragma once

#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace lcrig {

// "lcrigd: unknown option --confg; did you mean '--config'?", and a line that names the help.
std::string usage_error(const CLI::App& app, const CLI::ParseError& error);

// Prints the answer to --help, to --version or to a mistake of the command line, and returns the
// exit status of the program. An answer that cannot be written is a failure.
int answer_parse(const CLI::App& app, const CLI::ParseError& error);
// 1, said on standard error, if what was printed did not get through; else 0.
int end_of_output(const CLI::App& app);

}  // namespace lcrig
