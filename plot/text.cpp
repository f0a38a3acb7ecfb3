// SPDX-License-Identifier: Apache-2.0
#include "plot/text.hpp"

#include <algorithm>

#include "base/text.hpp"

namespace lcrig::plot {

namespace {

constexpr char32_t kReplacement = 0xFFFD;

// Each byte that is not UTF-8 becomes one U+FFFD.
char32_t next_character(std::string_view& text) {
  const char32_t c = take_character(text);
  return c == kNotUtf8 ? kReplacement : c;
}

char32_t made_visible(char32_t c) {
  if (c == '\n' || c == '\t') return c;
  if (c < 0x20) return 0x2400 + c;
  if (c == 0x7F) return 0x2421;
  const bool no_xml = c == 0xFFFE || c == 0xFFFF;
  return is_steering(c) || no_xml ? kReplacement : c;
}

// Width in em, from Helvetica's widths rounded up. Similar faces are narrower.
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
