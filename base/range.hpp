// SPDX-License-Identifier: Apache-2.0
// The interval that a number must lie in, and its words in messages. Used by the readers of files
// and the tables of limits.
#pragma once

#include <string>

namespace lcrig {

// An interval that includes both ends, unless `open_min` excludes the lower one. Quantities are
// compared in SI.
struct Range {
  double min = -1e300, max = 1e300;
  bool open_min = false;  // min itself is refused ("greater than 0")
};
bool contains(const Range& range, double v);
// "from 0 to 5"; the bounds are divided by `unit`.
std::string range_words(const Range& range, double unit = 1);
inline constexpr Range kAnyNumber{};
inline constexpr Range kPositive{0, 1e300, true};
inline constexpr Range kNotNegative{0, 1e300, false};

}  // namespace lcrig
