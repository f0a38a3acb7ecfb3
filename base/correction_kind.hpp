// SPDX-License-Identifier: Apache-2.0
// The two corrections of an LCR meter. The database, the control socket and the command line hold
// the words.
#pragma once

#include "base/enum_words.hpp"

namespace lcrig {

enum class CorrectionKind { open, short_circuit };
template <>
inline constexpr EnumWords<2> kWordsOf<CorrectionKind>{"open", "short"};

}  // namespace lcrig
