// SPDX-License-Identifier: Apache-2.0
// Finds the known word that a mistyped one probably stands for. Used by the readers of files and by
// the command line.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lcrig {

// The words of `known` that `word` may mistype or begin. All that fit equally well are returned.
// Upper and lower case count as equal.
std::vector<std::string> nearest_words(std::string_view word, std::span<const std::string> known);
// The one word that fits; nullopt also when two fit equally well, because either may be meant.
std::optional<std::string> nearest_word(std::string_view word, std::span<const std::string> known);
// One or two words as a choice: "`force_N`", "`free` or `fixed`". "" for more than two, which are
// no help.
std::string alternatives(std::span<const std::string> words, char quote);
// How a message words a guess.
struct GuessStyle {
  std::string_view lead;
  char quote;
};
inline constexpr GuessStyle kGuessInFile{", ", '`'};
inline constexpr GuessStyle kGuessAtPrompt{"; ", '\''};  // on the command line
// ", did you mean `force_N`?", or "" when no known word is near.
std::string did_you_mean(std::string_view word, std::span<const std::string> known,
                         const GuessStyle& style = kGuessInFile);
// The same for a guess that was found in another way; "" without one.
std::string guess_words(const std::optional<std::string>& meant,
                        const GuessStyle& style = kGuessInFile);
// Joins a guess to the words after it: "," if there is none.
std::string or_comma(std::string guess);

}  // namespace lcrig
