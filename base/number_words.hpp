// SPDX-License-Identifier: Apache-2.0
// What to say of a text that stands where a number is expected.
#pragma once

#include <string>
#include <string_view>

namespace lcrig {

// Why `text` is no number, where people write it as one: "−5", "+5", "1e999", "1,5", "12 um" (only
// with the unit `unit`). "": no such reason is known.
std::string number_words(std::string_view text, std::string_view unit = {});

}  // namespace lcrig
