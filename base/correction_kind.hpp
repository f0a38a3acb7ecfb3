// SPDX-License-Identifier: Apache-2.0
// The two corrections of an LCR meter. Their words are part of the database, the control socket and
// the command line. Used by drivers, storage and the daemon.
#pragma once

#include "base/enum_words.hpp"

namespace lcrig {

enum class CorrectionKind { open, short_circuit };
template <>
inline constexpr EnumWords<2> kWordsOf<CorrectionKind>{"open", "short"};

}  // namespace lcrig
