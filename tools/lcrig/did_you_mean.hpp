// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lcrig::cli {

// The known word nearest to `typed` (edit distance with swaps), or nothing when none is near.
std::optional<std::string> nearest_word(std::string_view typed,
                                        const std::vector<std::string>& known);
// "; did you mean 'run'?" or "".
std::string did_you_mean(std::string_view typed, const std::vector<std::string>& known);
// "a, b, c"
std::string join_words(const std::vector<std::string>& words);

}  // namespace lcrig::cli
