// SPDX-License-Identifier: Apache-2.0
// Finds what somebody meant who typed a word that nobody knows. Used by the readers of files and by
// the command line.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace lcrig {

// The nearest of `known` to `word`, if it is near enough that `word` may be a typing error, or the
// beginning of it.
std::optional<std::string> nearest_word(std::string_view word, std::span<const std::string> known);
// ", did you mean `force_N`?", or "" when no known word is near.
std::string did_you_mean(std::string_view word, std::span<const std::string> known);

}  // namespace lcrig
