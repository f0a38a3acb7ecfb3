// SPDX-License-Identifier: Apache-2.0
#include "base/text_place.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <vector>

#include "base/text.hpp"

namespace lcrig {

namespace {

std::size_t line_begin(std::string_view text, int line) {
  std::size_t at = text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
  for (int i = 1; i < line; ++i) at = next_line(text, at);
  return at;
}

}  // namespace

std::size_t byte_of(std::string_view text, TextPosition at) {
  std::string_view rest = text.substr(line_begin(text, at.line));
  for (int column = 1; column < at.column && !rest.empty(); ++column) take_character(rest);
  return text.size() - rest.size();
}

std::string excerpt(std::string_view text, TextPosition at) {
  constexpr int kExcerptMax = 72;
  text = text.substr(line_begin(text, at.line));
  text = text.substr(0, text.find_first_of("\r\n"));
  const int first = std::max(1, at.column - kExcerptMax / 2);
  std::string shown, below;
  for (int column = 1; column < first + kExcerptMax && !text.empty(); ++column) {
    const std::string_view before = text;
    const char32_t c = take_character(text);
    if (column < first) continue;
    const bool plain = c != kNotUtf8 && !is_steering(c);
    shown += plain ? before.substr(0, before.size() - text.size()) : "?";
    if (column < at.column) below += ' ';
  }
  return fmt::format("{}\n{}^", shown, below);
}

bool has_text_below(std::string_view text, int line) {
  return !trimmed(text.substr(line_begin(text, line + 1))).empty();
}

Result<> refuse_at(std::string_view text, std::span<const TextPosition> places,
                   const std::function<std::string(std::size_t)>& what) {
  constexpr std::size_t kShown = 20;
  if (places.empty()) return {};
  std::vector<std::size_t> order(places.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {},
                    [&](std::size_t i) { return std::tuple(places[i].line, places[i].column, i); });
  Error error(Errc::invalid_request, what(order.front()));
  error.detail = excerpt(text, places[order.front()]);
  for (std::size_t i = 1; i < std::min(kShown, order.size()); ++i) {
    error.detail += fmt::format("\n{}\n{}", what(order[i]), excerpt(text, places[order[i]]));
  }
  if (order.size() > kShown) {
    error.detail += fmt::format("\n... and {} more", order.size() - kShown);
  }
  return fail(std::move(error));
}

}  // namespace lcrig
