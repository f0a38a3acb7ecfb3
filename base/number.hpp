// SPDX-License-Identifier: Apache-2.0
// Reads a number that somebody wrote into a file, a command line or the line of an instrument.
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace lcrig {

// The number that `text` is, from its first character to its last. Not of "+1", "inf" or "nan".
template <class T>
std::optional<T> number_from(std::string_view text) {
  T value{};
  const auto r = std::from_chars(text.data(), text.data() + text.size(), value);
  if (r.ec != std::errc() || r.ptr != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

}  // namespace lcrig
