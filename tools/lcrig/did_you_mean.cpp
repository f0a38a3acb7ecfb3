// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/did_you_mean.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/near_word.hpp"

namespace lcrig::cli {

std::string did_you_mean(std::string_view typed, const std::vector<std::string>& known) {
  const auto word = nearest_word(typed, known);
  return word ? fmt::format("; did you mean '{}'?", *word) : std::string();
}

std::string join_words(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace lcrig::cli
