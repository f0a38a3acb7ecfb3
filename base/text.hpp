// SPDX-License-Identifier: Apache-2.0
// Text from outside (operator notes, instrument replies, files): UTF-8, and made harmless for a
// terminal or a log line. CSV cells are made harmless in analysis/csv, HTML and SVG in plot/text.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace lcrig {

inline constexpr char32_t kNotUtf8 = 0xFFFFFFFF;

// Takes one character off the front of `text`, which is not empty; what is no UTF-8 (cut off,
// overlong, a surrogate) is one byte and kNotUtf8.
char32_t take_character(std::string_view& text);
void append_utf8(std::string& out, char32_t c);
bool is_utf8(std::string_view text);

// Steers what shows it: control characters (also U+0080..9F, which are escape codes to some
// terminals), line and paragraph separators, and characters that reorder text.
bool is_steering(char32_t c);

// One line that no terminal obeys: steering characters and bytes that are no UTF-8 become \xNN or
// \uNNNN, the rest stays.
std::string printable(std::string_view text);
// The same, cut after `most` characters: "… (1048576 bytes)" says that it was.
std::string printable(std::string_view text, std::size_t most);
// A file on a terminal: line feeds and tabs stay.
std::string printable_lines(std::string_view text);

// How long a text of a person may be, bytes.
inline constexpr std::size_t kNameMax = 200;  // specimen, operator
inline constexpr std::size_t kWhyMax = 2'000;  // of an abort
inline constexpr std::size_t kNoteMax = 64 << 10;
// Refuses what is longer, no UTF-8, or holds a NUL. `what` names it in the message: "note".
Result<> check_text(std::string_view what, std::string_view text, std::size_t most);

}  // namespace lcrig
