// SPDX-License-Identifier: Apache-2.0
// Completion in the shell for the programs without subcommands: lcrigd and lcrig-sim. The shell
// asks `PROGRAM __complete -- WORD...`, as it asks lcrig, and gets the same form of answer: how
// files are offered, then a line for each word, a tab, and what it is (tools/completion/).
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace lcrig {

struct OptionValues {
  std::string files = "none";  // "none", "file", "json" or "dir"
  std::vector<std::string> words;
};

// `values`: of options that are not given a number, by name ("--bench"). nullopt: nobody asks.
std::optional<std::string> completion_of(const CLI::App& app,
                                         const std::map<std::string, OptionValues>& values,
                                         std::span<const char* const> arguments);

}  // namespace lcrig
