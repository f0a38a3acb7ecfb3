// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/did_you_mean.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/near_word.hpp"
#include "base/units.hpp"

namespace lcrig::cli {

std::string did_you_mean_option(std::string_view typed, const std::vector<std::string>& known) {
  const auto as_key = [](std::string_view option) {
    std::string key(option.substr(0, option.find('=')));
    std::ranges::replace(key, '-', '_');
    return key;
  };
  std::vector<std::string> keys, same_unit;
  for (const auto& option : known) keys.push_back(as_key(option));
  const std::string key = as_key(typed);
  const auto unit = split_key(key).unit;
  for (std::size_t i = 0; i < known.size(); ++i) {
    const KeyParts other = split_key(keys[i]);
    const bool no_unit = other.unit == nullptr;
    if (no_unit || other.unit == unit) same_unit.push_back(known[i]);
    if (no_unit || other.unit == unit || !key.starts_with(other.stem)) continue;
    if (key.size() > other.stem.size() && key[other.stem.size()] != '_') continue;
    return fmt::format("; it is {}, in {}", known[i], for_people(*other.unit));
  }
  return did_you_mean(typed.substr(0, typed.find('=')), same_unit, kGuessAtPrompt);
}

std::string join_words(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace lcrig::cli
