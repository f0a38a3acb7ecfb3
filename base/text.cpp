// SPDX-License-Identifier: Apache-2.0
#include "base/text.hpp"

#include <array>
#include <cstdint>

namespace lcrig {

namespace {

std::size_t bytes_of(unsigned char lead) {
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead < 0xE0) return 2;
  if (lead >= 0xE0 && lead < 0xF0) return 3;
  return lead >= 0xF0 && lead < 0xF5 ? 4 : 0;
}

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
  const auto lead = static_cast<unsigned char>(text.front());
  const std::size_t count = bytes_of(lead);
  char32_t c = count == 1 ? lead : lead & (0xFFU >> (count + 1));
  bool good = count > 0 && text.size() >= count;
  for (std::size_t i = 1; good && i < count; ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    good = (byte & 0xC0U) == 0x80U;
    c = (c << 6U) | (byte & 0x3FU);
  }
  constexpr std::array<char32_t, 5> kShortest{0, 0, 0x80, 0x800, 0x10000};
  good = good && c >= kShortest[count] && c <= 0x10FFFF && !(c >= 0xD800 && c < 0xE000);
  text.remove_prefix(good ? count : 1);
  return good ? c : kNotUtf8;
}

void append_utf8(std::string& out, char32_t c) {
  const auto tail = [&](unsigned shift) {
    out += static_cast<char>(0x80U | ((c >> shift) & 0x3FU));
  };
  if (c < 0x80) {
    out += static_cast<char>(c);
  } else if (c < 0x800) {
    out += static_cast<char>(0xC0U | (c >> 6U));
    tail(0);
  } else if (c < 0x10000) {
    out += static_cast<char>(0xE0U | (c >> 12U));
    tail(6);
    tail(0);
  } else {
    out += static_cast<char>(0xF0U | (c >> 18U));
    tail(12);
    tail(6);
    tail(0);
  }
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    if (take_character(text) == kNotUtf8) return false;
  }
  return true;
}

bool is_steering(char32_t c) {
  const bool control = c < 0x20 || (c >= 0x7F && c < 0xA0);
  const bool separates = c == 0x2028 || c == 0x2029;
  const bool reorders =
      c == 0x200E || c == 0x200F || (c >= 0x202A && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069);
  return control || separates || reorders;
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
