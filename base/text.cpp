// SPDX-License-Identifier: Apache-2.0
#include "base/text.hpp"

#include <utf8.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <iterator>

namespace lcrig {

namespace {

void append_escaped(std::string& out, char32_t c, std::string_view bytes) {
  if (c != kNotUtf8 && c >= 0x80) {
    out += fmt::format("\\u{:04x}", static_cast<std::uint32_t>(c));
    return;
  }
  for (const char byte : bytes) out += fmt::format("\\x{:02x}", static_cast<unsigned char>(byte));
}

// Removes at most `most` characters from the front of `text` and returns them escaped.
std::string take_printable(std::string_view& text, std::size_t most, bool keep_lines) {
  std::string out;
  for (; !text.empty() && most > 0; --most) {
    const std::string_view before = text;
    const char32_t c = take_character(text);
    const auto bytes = before.substr(0, before.size() - text.size());
    const bool layout = keep_lines && (c == '\n' || c == '\t');
    if (c == kNotUtf8 || (is_steering(c) && !layout)) {
      append_escaped(out, c, bytes);
    } else {
      out += bytes;
    }
  }
  return out;
}

}  // namespace

char32_t take_character(std::string_view& text) {
  try {
    const auto* at = text.data();
    const char32_t c = utf8::next(at, text.data() + text.size());
    text.remove_prefix(static_cast<std::size_t>(at - text.data()));
    return c;
  } catch (const utf8::exception&) {
    text.remove_prefix(1);
    return kNotUtf8;
  }
}

void append_utf8(std::string& out, char32_t c) {
  utf8::unchecked::append(c, std::back_inserter(out));
}

bool is_utf8(std::string_view text) {
  return utf8::is_valid(text.begin(), text.end());
}

bool ends_line(std::string_view text, std::size_t at) {
  if (text[at] == '\n') return true;
  return text[at] == '\r' && (at + 1 == text.size() || text[at + 1] != '\n');
}

std::size_t next_line(std::string_view text, std::size_t from) {
  while (from < text.size() && !ends_line(text, from)) ++from;
  return std::min(from + 1, text.size());
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  const auto begin = text.find_first_not_of(kBlank);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

bool names_a_file(std::string_view typed) {
  return typed.find('/') != typed.npos || typed.ends_with(".json");
}

bool is_steering(char32_t c) {
  const bool control = c < 0x20 || (c >= 0x7F && c < 0xA0);
  const bool separates = c == 0x2028 || c == 0x2029;
  const bool reorders =
      c == 0x200E || c == 0x200F || (c >= 0x202A && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069);
  return control || separates || reorders;
}

std::string lower_case(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), [](unsigned char c) { return std::tolower(c); });
  return out;
}

std::string either_of(std::span<const std::string> words) {
  std::string out = words.front();
  for (std::size_t i = 1; i < words.size(); ++i) {
    out += (i + 1 < words.size() ? ", " : " or ") + words[i];
  }
  return out;
}

void add_remark(std::string& sentence, std::string_view more) {
  if (!sentence.empty() && !more.empty()) sentence += "; ";
  sentence += more;
}

std::string printable(std::string_view text) {
  return take_printable(text, text.size(), false);
}

std::string printable(std::string_view text, std::size_t most) {
  const std::size_t bytes = text.size();
  std::string out = take_printable(text, most, false);
  if (!text.empty()) out += fmt::format("… ({} bytes)", bytes);
  return out;
}

std::string printable_lines(std::string_view text) {
  return take_printable(text, text.size(), true);
}

Result<> check_text(std::string_view what, std::string_view text, std::size_t most) {
  if (text.size() > most) {
    return fail(Errc::invalid_request, "{}: {} bytes, expected at most {}", what, text.size(),
                most);
  }
  if (!is_utf8(text)) return fail(Errc::invalid_request, "{}: is not UTF-8", what);
  if (text.find('\0') != std::string_view::npos) {
    return fail(Errc::invalid_request, "{}: holds a NUL character", what);
  }
  return {};
}

}  // namespace lcrig
