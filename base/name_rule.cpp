// SPDX-License-Identifier: Apache-2.0
#include "base/name_rule.hpp"

#include <fmt/format.h>

#include "base/text.hpp"

namespace lcrig {

namespace {

// Characters that a person cannot see or that look like a plain space: all spaces of Unicode (class
// Zs), and those of no width.
bool is_blank(char32_t c) {
  return c == 0x20 || c == 0xA0 || c == 0x1680 || (c >= 0x2000 && c <= 0x200D) || c == 0x202F ||
         c == 0x205F || c == 0x2060 || c == 0x3000 || c == 0xFEFF;
}

// The first of its characters that cannot stand in a name.
std::optional<std::string> wrong_character(std::string_view name) {
  std::size_t count = 0;
  for (std::string_view rest = name; !rest.empty(); ++count) {
    const std::string_view before = rest;
    const char32_t c = take_character(rest);
    const auto bytes = before.substr(0, before.size() - rest.size());
    if (printable(bytes) != bytes) return "a character that cannot be printed, expected none";
    if (c == '/') return "a slash, expected none: a word with a slash is taken for a file";
    if (is_blank(c) && c != ' ') return "an invisible character, expected plain spaces at most";
    if (c == ' ' && (count == 0 || rest.empty())) {
      return "a space at one end, expected none: nobody sees it";
    }
  }
  if (count > kLongestName) {
    return fmt::format("{} characters, expected at most {}: tables cut longer names", count,
                       kLongestName);
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> why_no_name(std::string_view name) {
  const auto quoted = [&](const char* what) {
    return fmt::format("\"{}\": {}", printable(name, kLongestName), what);
  };
  if (name.empty()) return "an empty name, expected at least one character";
  if (name.front() == '-') {
    return quoted("a dash at the front, expected another character: it is taken for an option");
  }
  if (name.ends_with(".json")) {
    return quoted("the end .json, expected a name without it: it is taken for a file");
  }
  if (name.starts_with("replay:")) {
    return quoted("\"replay:\" at the front, expected another name: it is taken for a recording");
  }
  const auto wrong = wrong_character(name);
  return wrong ? std::optional(quoted(wrong->c_str())) : std::nullopt;
}

}  // namespace lcrig
