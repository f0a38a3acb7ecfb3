// SPDX-License-Identifier: Apache-2.0
// Compares words of the meter's dialect, ignoring case. Used by codec, settings and simulator.
#pragma once

#include <string_view>

#include "base/text.hpp"

namespace lcrig::lcr6100 {

inline bool same_word(std::string_view a, std::string_view b) {
  return lower_case(a) == lower_case(b);
}

}  // namespace lcrig::lcr6100
