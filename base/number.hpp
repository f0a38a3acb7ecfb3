// SPDX-License-Identifier: Apache-2.0
// Reads a number that stands in a file, on a command line or in an instrument's line. All programs
// use it.
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

namespace lcrig {

// `text` as a number; nullopt unless all of it is one. Refuses "+1", "inf" and "nan".
template <class T>
std::optional<T> number_from(std::string_view text) {
  T value{};
  const auto r = std::from_chars(text.data(), text.data() + text.size(), value);
  if (r.ec != std::errc() || r.ptr != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

// Advice for "1,5" and for the ambiguous "1,000". "" when `text` is not a number with a comma.
inline std::string comma_words(std::string_view text) {
  const auto digits = [](std::string_view part) {
    return !part.empty() && part.find_first_not_of("0123456789") == part.npos;
  };
  const auto comma = text.find(',');
  if (comma == text.npos) return {};
  const auto whole = text.substr(0, comma), rest = text.substr(comma + 1);
  const auto unsigned_part = whole.starts_with('-') ? whole.substr(1) : whole;
  if (!digits(unsigned_part)) return {};
  const std::string first(whole), second(rest);
  if (digits(rest) && rest.size() == 3 && unsigned_part.size() <= 3 && unsigned_part[0] != '0') {
    return first + "." + second + " or " + first + second + "? A number has no `,`";
  }
  if (!digits(rest)) return "a number has no `,`; the decimal sign is a point";
  return "a decimal number is written with a point: " + first + "." + second;
}

// Why a text that people take for a number is not one: "−5", "+5", "1e999", "1,5", "12 um" (only
// when `unit` is that unit). "": no such reason is known.
std::string number_words(std::string_view text, std::string_view unit = {});

}  // namespace lcrig
