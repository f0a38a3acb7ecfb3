// SPDX-License-Identifier: Apache-2.0
// Proposals of the command line for a word that it does not know. Used by the parser and the lookup
// of library files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace lcrig::cli {

// "; did you mean '--seed'?" of an option: its unit is never guessed. "; it is --frequency-Hz, in
// Hz".
std::string did_you_mean_option(std::string_view typed, const std::vector<std::string>& known);
// "a, b, c"
std::string join_words(const std::vector<std::string>& words);

}  // namespace lcrig::cli
