// SPDX-License-Identifier: Apache-2.0
// The settings that a hand at the panel of a simulated meter can change. Used by fault scripts.
#pragma once

#include "base/enum_words.hpp"

namespace lcrig {

enum class PanelKey { function, frequency, level, aperture, average, range, bias, correction };
template <>
inline constexpr EnumWords<8> kWordsOf<PanelKey>{"function", "frequency", "level", "aperture",
                                                 "average",  "range",     "bias",  "correction"};

}  // namespace lcrig
