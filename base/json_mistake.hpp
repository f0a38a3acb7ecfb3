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

// The mistake of a text that is not UTF-8; nullopt for UTF-8.
std::optional<JsonMistake> find_encoding_mistake(std::string_view text);
// The ASCII characters of a UTF-16 text, for showing; "?" stands for the others. nullopt: it is not
// UTF-16.
std::optional<std::string> ascii_of_utf16(std::string_view text);

// The first mistake; nullopt when this knows no better words than the parser.
std::optional<JsonMistake> find_json_mistake(std::string_view text);

}  // namespace lcrig
