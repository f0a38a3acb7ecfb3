// SPDX-License-Identifier: Apache-2.0
#include "events/event_kind.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace lcrig {

namespace {

#define LCRIG_TEXT_OF(...) #__VA_ARGS__
#define LCRIG_TEXT(...) LCRIG_TEXT_OF(__VA_ARGS__)

// The words, in the order of the enumerators.
constexpr auto kWords = [] {
  std::array<std::string_view, static_cast<std::size_t>(EventKind::other)> words;
  std::string_view rest = LCRIG_TEXT(LCRIG_EVENT_KINDS);
  for (std::string_view& word : words) {
    word = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(word.size() + 2, rest.size()));  // with the ", " behind the word
  }
  return words;
}();

}  // namespace

std::string_view to_string(EventKind kind) {
  return kind == EventKind::other ? "other" : kWords[static_cast<std::size_t>(kind)];
}

std::vector<EventKind> all_event_kinds() {
  std::vector<EventKind> out;
  for (std::size_t i = 0; i < kWords.size(); ++i) out.push_back(static_cast<EventKind>(i));
  return out;
}

EventName::EventName(std::string word)
    : kind_(static_cast<EventKind>(std::ranges::find(kWords, word) - kWords.begin())),
      word_(std::move(word)) {}

}  // namespace lcrig
