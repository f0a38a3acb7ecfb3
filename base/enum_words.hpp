// SPDX-License-Identifier: Apache-2.0
// Reads the words of enumerations: those whose values count from 0 and have a `to_string`. Readers
// of the control socket, of batch files and of the database use it. `last`: the last value.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lcrig {

// nullopt: no value has this word.
template <class E>
std::optional<E> parse_word(std::string_view word, E last) {
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    if (to_string(static_cast<E>(i)) == word) return static_cast<E>(i);
  }
  return std::nullopt;
}

// For JsonReader::word.
template <class E>
std::vector<std::pair<std::string_view, E>> word_table(E last) {
  std::vector<std::pair<std::string_view, E>> out;
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    out.emplace_back(to_string(static_cast<E>(i)), static_cast<E>(i));
  }
  return out;
}

template <class E>
std::vector<std::string> words_up_to(E last) {
  std::vector<std::string> out;
  for (int i = 0; i <= static_cast<int>(last); ++i) out.emplace_back(to_string(static_cast<E>(i)));
  return out;
}

}  // namespace lcrig
