// SPDX-License-Identifier: Apache-2.0
// Checks text from outside (operator notes, instrument replies, files) and escapes it for a
// terminal or a log line. Used wherever such text is stored or shown. CSV cells are escaped in
// analysis/csv, HTML and SVG in plot/text.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace lcrig {

inline constexpr char32_t kNotUtf8 = 0xFFFFFFFF;

// Removes the first character of `text`, which must not be empty, and returns it. If the text is
// not UTF-8 there (cut off, overlong, a surrogate), it removes one byte and returns kNotUtf8.
char32_t take_character(std::string_view& text);
void append_utf8(std::string& out, char32_t c);
bool is_utf8(std::string_view text);

// Whether the character at `at` ends a line: LF, or a CR that no LF follows.
bool ends_line(std::string_view text, std::size_t at);
// Where the next line after `from` begins; the size of `text` when there is none.
std::size_t next_line(std::string_view text, std::size_t from);

constexpr bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
std::string lower_case(std::string_view text);  // changes ASCII letters only

// Removes blanks, tabs and line ends at both ends.
std::string_view trimmed(std::string_view text);

// True for characters that change how a terminal shows the text around them: control characters
// (also U+0080..9F, which some terminals read as escape codes), line and paragraph separators, and
// characters that reorder text.
bool is_steering(char32_t c);

// "a", "a or b", "a, b or c". There is at least one word.
std::string either_of(std::span<const std::string> words);

// Appends `more` to the sentence, after a semicolon.
void add_remark(std::string& sentence, std::string_view more);

// One line that is safe on a terminal: steering characters and bytes that are not UTF-8 become \xNN
// or \uNNNN.
std::string printable(std::string_view text);
// The same, cut after `most` characters; a cut text ends in "… (1048576 bytes)".
std::string printable(std::string_view text, std::size_t most);
// The same for several lines, e.g. a file: line feeds and tabs stay.
std::string printable_lines(std::string_view text);

// True when a typed word means a file, not a name that the program knows: it has a '/' or ends in
// ".json".
bool names_a_file(std::string_view typed);

// The longest texts that a person may enter, in bytes.
inline constexpr std::size_t kNameMax = 200;  // specimen, operator
inline constexpr std::size_t kWhyMax = 2'000;  // the reason of an abort
inline constexpr std::size_t kNoteMax = 64 << 10;
// Refuses text that is longer than `most` bytes, is not UTF-8, or contains a NUL. `what` names the
// text in the message, e.g. "note".
Result<> check_text(std::string_view what, std::string_view text, std::size_t most);

}  // namespace lcrig
