// SPDX-License-Identifier: Apache-2.0
// Explains in a person's words why a text is not JSON: a missing comma, a decimal comma, a `#`
// comment. strict_json asks it after its parser has refused a text.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace lcrig {

struct JsonMistake {
  std::size_t at = 0;  // offset in bytes
  std::string words;
};

// Why a text is not UTF-8; nullopt when it is.
std::optional<JsonMistake> find_encoding_mistake(std::string_view text);
// The ASCII characters of a UTF-16 text, with "?" for all others, to show it in a message. nullopt:
// not UTF-16.
std::optional<std::string> ascii_of_utf16(std::string_view text);

// The first mistake; nullopt when the parser's own words are as good.
std::optional<JsonMistake> find_json_mistake(std::string_view text);

}  // namespace lcrig
