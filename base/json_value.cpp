// SPDX-License-Identifier: Apache-2.0
// Reads one value of a document as a C++ type. Its keys and messages are in json_reader.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/near_word.hpp"
#include "base/strict_json.hpp"
#include "base/text.hpp"

namespace lcrig {

using nlohmann::json;

// The value as messages show it: short, and safe for a terminal.
std::string JsonReader::shown() const {
  if (is_object()) return "an object";
  if (is_array()) return "an array";
  std::string text = value_->dump(-1, ' ', false, json::error_handler_t::replace);
  return printable(text, 60);
}

bool JsonReader::is_object() const {
  return value_->is_object();
}
bool JsonReader::is_array() const {
  return value_->is_array();
}
bool JsonReader::is_string() const {
  return value_->is_string();
}
bool JsonReader::is_number() const {
  return value_->is_number();
}
bool JsonReader::is_boolean() const {
  return value_->is_boolean();
}
bool JsonReader::is_null() const {
  return value_->is_null();
}

double JsonReader::number(const Range& range) const {
  return number_in(1, range);
}

double JsonReader::number_in(double to_si, const Range& si) const {
  if (!is_number()) {
    refuse(fmt::format("{}, expected a number", shown()));
    return 0;
  }
  const double v = value_->get<double>() * to_si;
  if (!contains(si, v)) refuse(fmt::format("{}, expected {}", shown(), range_words(si, to_si)));
  return v;
}

std::int64_t JsonReader::integer(std::int64_t min, std::int64_t max) const {
  const auto expected = [&] {
    return fmt::format("expected a whole number from {} to {}", min, max);
  };
  const double v = is_number() ? value_->get<double>() : std::nan("");
  // 2^53: above it a double cannot represent every integer.
  if (!(std::abs(v) <= 9007199254740992.0) || v != std::floor(v)) {
    refuse(fmt::format("{}, {}", shown(), expected()));
    return 0;
  }
  const auto n = static_cast<std::int64_t>(v);
  if (n < min || n > max) refuse(fmt::format("{}, {}", shown(), expected()));
  return n;
}

bool JsonReader::boolean() const {
  if (is_boolean()) return value_->get<bool>();
  refuse(fmt::format("{}, expected true or false", shown()));
  return false;
}

std::string JsonReader::string() const {
  if (is_string()) return value_->get<std::string>();
  refuse(fmt::format("{}, expected a string", shown()));
  return {};
}

std::string JsonReader::nonempty_string(std::size_t max_bytes) const {
  std::string text = string();
  if (is_string() && (text.empty() || text.size() > max_bytes)) {
    refuse(fmt::format("a string of {} bytes, expected 1 to {}", text.size(), max_bytes));
  }
  return text;
}

std::size_t JsonReader::word_index(std::span<const std::string> words) const {
  const std::string text = string();
  const auto it = std::ranges::find(words, text);
  if (it != words.end()) return static_cast<std::size_t>(it - words.begin());
  if (is_string()) {
    refuse(fmt::format("{}{} expected one of {}", shown(), or_comma(did_you_mean(text, words)),
                       fmt::join(words, ", ")));
  }
  return 0;
}

double JsonReader::number(std::string_view key, const Range& range) const {
  return at(key).number(range);
}
std::int64_t JsonReader::integer(std::string_view key, std::int64_t min, std::int64_t max) const {
  return at(key).integer(min, max);
}
bool JsonReader::boolean(std::string_view key) const {
  return at(key).boolean();
}
std::string JsonReader::string(std::string_view key) const {
  return at(key).string();
}
std::optional<double> JsonReader::optional_number(std::string_view key, const Range& r) const {
  const auto v = find(key);
  return v ? std::optional(v->number(r)) : std::nullopt;
}
std::optional<std::int64_t> JsonReader::optional_integer(std::string_view key, std::int64_t min,
                                                         std::int64_t max) const {
  const auto v = find(key);
  return v ? std::optional(v->integer(min, max)) : std::nullopt;
}
std::optional<bool> JsonReader::optional_boolean(std::string_view key) const {
  const auto v = find(key);
  return v ? std::optional(v->boolean()) : std::nullopt;
}
std::optional<std::string> JsonReader::optional_string(std::string_view key) const {
  const auto v = find(key);
  return v ? std::optional(v->string()) : std::nullopt;
}

}  // namespace lcrig
