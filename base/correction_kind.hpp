// SPDX-License-Identifier: Apache-2.0
// The two corrections of an LCR meter. The database, the control socket and the command line hold
// the words.
#pragma once

#include <string_view>

namespace lcrig {

enum class CorrectionKind { open, short_circuit };
constexpr std::string_view to_string(CorrectionKind kind) {
  return kind == CorrectionKind::open ? "open" : "short";
}

}  // namespace lcrig
