// SPDX-License-Identifier: Apache-2.0
// Compares words of the meter's dialect, which may have blanks around them and either case. Used by
// codec, settings and simulator.
#pragma once

#include <algorithm>
#include <cctype>
#include <string_view>

namespace lcrig::lcr6100 {

// Removes blanks and carriage returns at both ends.
inline std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

inline bool same_word(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  return std::ranges::equal(a, b, {}, lower, lower);
}

}  // namespace lcrig::lcr6100
