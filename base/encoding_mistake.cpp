// SPDX-License-Identifier: Apache-2.0
// Recognises files in another encoding than UTF-8, for json_mistake.hpp.
#include <fmt/format.h>

#include <algorithm>

#include "base/json_mistake.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

bool is_big_endian(std::string_view text) {
  return text.starts_with("\xFE\xFF") || text.starts_with('\0');
}

// UTF-16 begins with a byte order mark, or has a zero byte in its first character. Binary files may
// do so too, therefore most of the beginning must be ASCII, as it is in JSON.
bool is_utf16(std::string_view text) {
  const bool marked = text.starts_with("\xFE\xFF") || text.starts_with("\xFF\xFE");
  const bool half = text.size() >= 2 && (text[0] == '\0') != (text[1] == '\0');
  if (!marked && !half) return false;
  const std::size_t high = is_big_endian(text) ? 0 : 1;
  std::size_t ascii = 0, all = 0;
  for (std::size_t i = marked ? 2 : 0; i + 1 < text.size() && all < 64; i += 2, ++all) {
    const auto low = static_cast<unsigned char>(text[i + 1 - high]);
    if (text[i + high] == '\0' && low < 0x80 && (low >= ' ' || low == '\n' || low == '\r')) ++ascii;
  }
  return 2 * ascii > all;
}

// True for control characters near the beginning, which no text has in any encoding.
bool is_binary(std::string_view text) {
  constexpr std::size_t kBeginning = 512;
  return std::ranges::any_of(text.substr(0, kBeginning), [](unsigned char c) {
    return c < ' ' && c != '\n' && c != '\r' && c != '\t';
  });
}

}  // namespace

std::optional<JsonMistake> find_encoding_mistake(std::string_view text) {
  if (is_utf16(text)) return JsonMistake{0, "the file is UTF-16: save it as UTF-8"};
  if (!is_utf8(text) && is_binary(text)) {
    return JsonMistake{0, "this is no text file, expected an object of JSON: { ... }"};
  }
  for (std::string_view rest = text; !rest.empty();) {
    const auto at = text.size() - rest.size();
    const auto byte = static_cast<unsigned char>(rest.front());
    if (take_character(rest) != kNotUtf8) continue;
    std::string words = fmt::format("the byte \\x{:02x} is not UTF-8", byte);
    if (byte >= 0xA0) {
      std::string letter;
      append_utf8(letter, byte);
      words += fmt::format(" (in Latin-1 and Windows-1252 it is `{}`)", letter);
    }
    return JsonMistake{at, words + ": save the file as UTF-8"};
  }
  return std::nullopt;
}

std::optional<std::string> ascii_of_utf16(std::string_view text) {
  if (!is_utf16(text)) return std::nullopt;
  const bool big_endian = is_big_endian(text);
  const bool marked = text.starts_with("\xFE\xFF") || text.starts_with("\xFF\xFE");
  std::string out;
  for (std::size_t i = marked ? 2 : 0; i + 1 < text.size(); i += 2) {
    const char low = text[i + (big_endian ? 1 : 0)], high = text[i + (big_endian ? 0 : 1)];
    out += high == '\0' && static_cast<unsigned char>(low) < 0x80 ? low : '?';
  }
  return out;
}

}  // namespace lcrig
