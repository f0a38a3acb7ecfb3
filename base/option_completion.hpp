// SPDX-License-Identifier: Apache-2.0
// Shell completion for the programs without subcommands: lcrigd and lcrig-sim. The shell asks
// `PROGRAM __complete -- WORD...`, as it asks lcrig, and the answer has the same form: how files
// are offered, then one line for each word with a tab and its explanation (tools/completion/).
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

// `values`: by name ("--bench"), the values of options that do not take a number. nullopt: this is
// no request for completion.
std::optional<std::string> completion_of(const CLI::App& app,
                                         const std::map<std::string, OptionValues>& values,
                                         std::span<const char* const> arguments);

}  // namespace lcrig
