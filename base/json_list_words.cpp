// SPDX-License-Identifier: Apache-2.0
#include "base/json_list_words.hpp"

#include <nlohmann/json.hpp>

namespace lcrig {

using nlohmann::json;

namespace {

std::string counted(std::size_t items) {
  return items == 1 ? "1 item" : fmt::format("{} items", items);
}

std::string count_words(std::size_t min, std::size_t max) {
  if (max == SIZE_MAX) return fmt::format("at least {}", min);
  return min == max ? fmt::format("{}", min) : fmt::format("{} to {}", min, max);
}

// [-0.2, 1,5] is a list of three numbers to JSON, and of two to many people: there is no blank
// behind the comma.
std::string comma_doubt(const JsonDocument& document, const std::string& list, std::size_t min,
                        std::size_t max) {
  const std::size_t size = document.root()[json::json_pointer(list)].size();
  const auto digits = [](std::string_view text) {
    return !text.empty() && text.find_first_not_of("0123456789") == text.npos;
  };
  std::string first;
  std::size_t left = size;
  for (std::size_t i = 0; i + 1 < size; ++i) {
    const auto here = fmt::format("{}/{}", list, i), next = fmt::format("{}/{}", list, i + 1);
    const TextPosition at = document.value_position(here), then = document.value_position(next);
    const auto whole = document.number_text(here), fraction = document.number_text(next);
    const bool close =
        at.line == then.line && then.column == at.column + static_cast<int>(whole.size()) + 1;
    if (!close || !digits(fraction)) continue;
    if (!digits(whole.starts_with('-') ? whole.substr(1) : whole)) continue;
    if (first.empty()) first = whole + "." + fraction;
    --left;
    ++i;
  }
  if (first.empty() || left < min || left > max) return {};
  return fmt::format("; is a decimal comma among them? A number has a point: {}", first);
}

}  // namespace

std::string list_size_words(const JsonDocument& document, const std::string& pointer,
                            std::size_t min, std::size_t max) {
  const std::size_t size = document.root()[json::json_pointer(pointer)].size();
  return fmt::format("{}, expected {}{}", counted(size), count_words(min, max),
                     size > max ? comma_doubt(document, pointer, min, max) : std::string());
}

}  // namespace lcrig
