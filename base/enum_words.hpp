// SPDX-License-Identifier: Apache-2.0
// Gives enumerations their words in files, messages, database rows and on the command line. Used by
// every enum that is stored, sent or typed. An enum whose values count from 0 has one list of words
// beside it:
//
//   template <>
//   inline constexpr EnumWords<2> kWordsOf<Lateral>{"free", "confined"};
//
// This list gives the enum its `to_string` and all functions below.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lcrig {

template <std::size_t n>
using EnumWords = std::array<std::string_view, n>;
template <class E>
inline constexpr EnumWords<0> kWordsOf{};  // empty for an enum without words
template <class E>
concept HasWords = !kWordsOf<E>.empty();

template <HasWords E>
constexpr std::string_view to_string(E value) {
  return kWordsOf<E>[static_cast<std::size_t>(value)];
}

// nullopt: no value has this word.
template <HasWords E>
std::optional<E> parse_word(std::string_view word) {
  for (std::size_t i = 0; i < kWordsOf<E>.size(); ++i) {
    if (kWordsOf<E>[i] == word) return static_cast<E>(i);
  }
  return std::nullopt;
}

// The table that JsonReader::word takes.
template <HasWords E>
std::vector<std::pair<std::string_view, E>> word_table() {
  std::vector<std::pair<std::string_view, E>> out;
  for (std::size_t i = 0; i < kWordsOf<E>.size(); ++i) {
    out.emplace_back(kWordsOf<E>[i], static_cast<E>(i));
  }
  return out;
}

template <HasWords E>
std::vector<std::string> all_words() {
  return {kWordsOf<E>.begin(), kWordsOf<E>.end()};
}

}  // namespace lcrig
