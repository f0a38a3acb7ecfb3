// SPDX-License-Identifier: Apache-2.0
// Says what is wrong with a text that is no JSON in the words of a person: a comma that is missing,
// a decimal comma, a `#` comment. For strict_json, which asks after its parser has refused the
// text.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace lcrig {

struct JsonMistake {
  std::size_t at = 0;  // byte
  std::string words;
};

// Of a text that is not UTF-8; nullopt: it is.
std::optional<JsonMistake> find_encoding_mistake(std::string_view text);
// UTF-16 as far as it is ASCII, for showing; "?" stands for the rest. nullopt: it is no UTF-16.
std::optional<std::string> ascii_of_utf16(std::string_view text);

// The first mistake; nullopt when this knows no better words than the parser.
std::optional<JsonMistake> find_json_mistake(std::string_view text);

}  // namespace lcrig
