// SPDX-License-Identifier: Apache-2.0
// Proposals for a word that the command line does not know. Used by the parser, by the lookup of
// library files and by `lcrig runs`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace lcrig::cli {

// For an option: "; did you mean '--seed'?". A unit is never guessed: "; it is --frequency-Hz, in
// Hz".
std::string did_you_mean_option(std::string_view typed, const std::vector<std::string>& known);
// "a, b, c"
std::string join_words(const std::vector<std::string>& words);

}  // namespace lcrig::cli
