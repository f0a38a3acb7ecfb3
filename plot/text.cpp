// SPDX-License-Identifier: Apache-2.0
#include "plot/text.hpp"

#include <array>
#include <cstdint>
#include <optional>

namespace lcrig::plot {

namespace {

constexpr char32_t kReplacement = 0xFFFD;

int bytes_of(unsigned char lead) {
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead < 0xE0) return 2;
  if (lead >= 0xE0 && lead < 0xF0) return 3;
  return lead >= 0xF0 && lead < 0xF5 ? 4 : 0;
}

// Takes one character off the front; what is no UTF-8 is one U+FFFD a byte.
char32_t next_character(std::string_view& text) {
  const auto lead = static_cast<unsigned char>(text.front());
  const int count = bytes_of(lead);
  char32_t c = count == 1 ? lead : lead & (0xFFU >> (count + 1));
  bool good = count > 0 && text.size() >= static_cast<std::size_t>(count);
  for (int i = 1; good && i < count; ++i) {
    const auto byte = static_cast<unsigned char>(text[static_cast<std::size_t>(i)]);
    good = (byte & 0xC0U) == 0x80U;
    c = (c << 6U) | (byte & 0x3FU);
  }
  constexpr std::array<char32_t, 5> kShortest{0, 0, 0x80, 0x800, 0x10000};
  good = good && c >= kShortest[static_cast<std::size_t>(count)] && c <= 0x10FFFF &&
         !(c >= 0xD800 && c < 0xE000);
  text.remove_prefix(good ? static_cast<std::size_t>(count) : 1);
  return good ? c : kReplacement;
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

char32_t made_visible(char32_t c) {
  if (c == '\n' || c == '\t') return c;
  if (c < 0x20) return 0x2400 + c;
  if (c == 0x7F) return 0x2421;
  const bool reorders = (c >= 0x202A && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069);
  const bool no_xml = c == 0xFFFE || c == 0xFFFF;
  return (c >= 0x80 && c < 0xA0) || reorders || no_xml ? kReplacement : c;
}

// In em, of Helvetica's widths rounded up; other faces of the kind are narrower.
double em_of(char32_t c) {
  constexpr std::string_view kNarrow = "ijl|!.,:;'`";
  constexpr std::string_view kSlim = "()[]{}-\"/\\ frt*I";
  constexpr std::string_view kWide = "MW@%m";
  if (c < 0x80) {
    const char ascii = static_cast<char>(c);
    if (kNarrow.find(ascii) != kNarrow.npos) return 0.30;
    if (kSlim.find(ascii) != kSlim.npos) return 0.38;
    if (kWide.find(ascii) != kWide.npos) return 0.95;
    return (c >= 'A' && c <= 'Z') || c == '&' || c == 'w' ? 0.76 : 0.60;
  }
  return c < 0x1100 || (c >= 0x2000 && c < 0x2300) ? 0.66 : 1.1;
}

}  // namespace

std::string escape(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const char32_t c = made_visible(next_character(text));
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default: append_utf8(out, c);
    }
  }
  return out;
}

double text_width(std::string_view text, double font_size) {
  double em = 0;
  while (!text.empty()) em += em_of(made_visible(next_character(text)));
  return em * font_size;
}

std::string cut_to_width(std::string_view text, double width, double font_size) {
  if (text_width(text, font_size) <= width) return std::string(text);
  constexpr std::string_view kEllipsis = "…";
  double used = text_width(kEllipsis, font_size);
  std::string out;
  while (!text.empty()) {
    const char32_t c = next_character(text);
    used += em_of(made_visible(c)) * font_size;
    if (used > width) break;
    append_utf8(out, c);
  }
  return out + std::string(kEllipsis);
}

std::vector<std::string> wrap(std::string_view text, double width, double font_size) {
  std::vector<std::string> lines;
  std::string line;
  while (!text.empty()) {
    const auto end = std::min(text.find_first_of(" \n\t"), text.size());
    const std::string word = cut_to_width(text.substr(0, end), width, font_size);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::string joined = line.empty() ? word : line + " " + word;
    if (line.empty() || text_width(joined, font_size) <= width) {
      line = joined;
    } else {
      lines.push_back(std::move(line));
      line = word;
    }
  }
  if (!line.empty()) lines.push_back(std::move(line));
  return lines;
}

}  // namespace lcrig::plot
