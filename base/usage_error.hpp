// SPDX-License-Identifier: Apache-2.0
// What CLI11 refuses, as a person would say it, with what to type next. For programs without
// subcommands: lcrigd and lcrig-sim.
#pragma once

#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace lcrig {

// "lcrigd: unknown option --confg; did you mean '--config'?", and a line that names the help.
std::string usage_error(const CLI::App& app, const CLI::ParseError& error);

// What --help, --version and mistakes of the command line are answered with, and the program's exit
// status. An answer that nobody gets is a failure.
int answer_parse(const CLI::App& app, const CLI::ParseError& error);
// 1, said on standard error, if what was printed did not get through; else 0.
int end_of_output(const CLI::App& app);

}  // namespace lcrig
