// SPDX-License-Identifier: Apache-2.0
// Chooses which area carries the charge when an electrode is stretched. An option of the
// finite-element levels (level.hpp).
#pragma once

#include "base/enum_words.hpp"

namespace lcrig {

// reference: the printed disc. deformed: the stretched upper electrode, as a field solver on the
// deformed mesh sees it.
enum class ElectrodeArea { reference, deformed };
template <>
inline constexpr EnumWords<2> kWordsOf<ElectrodeArea>{"reference", "deformed"};

}  // namespace lcrig
