// SPDX-License-Identifier: Apache-2.0
// Words about a text that stands where a number is expected. The reader of parameters and that of
// answers use them.
#pragma once

#include <string>
#include <string_view>

namespace lcrig {

// Why `text` is no number, where people write it as one: "−5", "+5", "1e999", "1,5", "12 um" (only
// with the unit `unit`). "": no such reason is known.
std::string number_words(std::string_view text, std::string_view unit = {});

}  // namespace lcrig
