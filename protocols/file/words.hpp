// SPDX-License-Identifier: Apache-2.0
// Sentences in parts.
#pragma once

#include <string>
#include <string_view>

namespace lcrig {

inline void add_note(std::string& note, std::string_view text) {
  if (!note.empty()) note += "; ";
  note += text;
}

}  // namespace lcrig
