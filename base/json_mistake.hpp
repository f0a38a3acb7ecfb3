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

// The first mistake; nullopt when this knows no better words than the parser.
std::optional<JsonMistake> find_json_mistake(std::string_view text);

}  // namespace lcrig
