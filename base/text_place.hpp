// SPDX-License-Identifier: Apache-2.0
// Places in a text, as messages name them. Lines end with LF, CR LF or CR. Used by strict_json and
// by those who edit its texts.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace lcrig {

struct TextPosition {
  int line = 1, column = 1;  // columns count characters, not bytes
};

inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // no part of the first line

// The byte of `text` that is there; its size when nothing is.
std::size_t byte_of(std::string_view text, TextPosition at);
// The line of the place, at most 72 characters of it, and a caret below the place.
std::string excerpt(std::string_view text, TextPosition at);
bool has_text_below(std::string_view text, int line);

}  // namespace lcrig
