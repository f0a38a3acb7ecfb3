// SPDX-License-Identifier: Apache-2.0
// Compares words of the meter's dialect, which may have blanks around them and either case. Used by
// codec, settings and simulator.
#pragma once

#include <algorithm>
#include <cctype>
#include <string_view>

#include "base/text.hpp"

namespace lcrig::lcr6100 {

inline bool same_word(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  return std::ranges::equal(a, b, {}, lower, lower);
}

}  // namespace lcrig::lcr6100
