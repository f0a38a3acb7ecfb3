// SPDX-License-Identifier: Apache-2.0
// Words about a list with too few or too many items. Used by the JSON reader.
#pragma once

#include <string>

#include "base/strict_json.hpp"

namespace lcrig {

// "3 items, expected 2; is a decimal comma among them? ...", of the list that `pointer` names.
std::string list_size_words(const JsonDocument& document, const std::string& pointer,
                            std::size_t min, std::size_t max);

}  // namespace lcrig
