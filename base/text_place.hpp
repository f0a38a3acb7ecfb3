// SPDX-License-Identifier: Apache-2.0
// Converts between bytes and the lines and columns of a text that messages show. Lines end with LF,
// CR LF or CR. Used by strict_json and by code that edits JSON texts.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace lcrig {

struct TextPosition {
  int line = 1, column = 1;  // columns count characters, not bytes
};

inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // not counted in the first line

// The byte offset of a position; the size of `text` when it has no such position.
std::size_t byte_of(std::string_view text, TextPosition at);
// The line of the position, at most 72 characters of it, with a caret below the position.
std::string excerpt(std::string_view text, TextPosition at);
bool has_text_below(std::string_view text, int line);
// What is wrong at these places, all at once; no places: nothing is. In the order of the text,
// which people correct from its top: the first is the message, its `detail` shows the line with a
// caret and lists the others. `what` gives the words for a place, by its index.
Result<> refuse_at(std::string_view text, std::span<const TextPosition> places,
                   const std::function<std::string(std::size_t)>& what);

}  // namespace lcrig
