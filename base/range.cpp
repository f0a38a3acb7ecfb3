// SPDX-License-Identifier: Apache-2.0
#include "base/range.hpp"

#include <fmt/core.h>

#include <cmath>

namespace lcrig {

namespace {

// Six digits, as {:.6g}, but writes a large integer in full: 2592000, not 2.592e+06.
std::string bound(double v) {
  constexpr double kLargest = 1e9;
  const double size = std::abs(v);
  const bool whole = size >= 1e6 && size <= kLargest && v == std::floor(v);
  return whole ? fmt::format("{:.0f}", v) : fmt::format("{:.6g}", v);
}

}  // namespace

std::string range_words(const Range& r, double unit) {
  const bool low = r.min > -1e299, high = r.max < 1e299;
  const double min = r.min / unit, max = r.max / unit;
  if (low && high && !r.open_min) return fmt::format("from {} to {}", bound(min), bound(max));
  if (low && high) return fmt::format("greater than {}, at most {}", bound(min), bound(max));
  if (low && r.open_min) return "greater than " + bound(min);
  if (low) return "at least " + bound(min);
  return "at most " + bound(max);
}

bool contains(const Range& r, double v) {
  return v <= r.max && (r.open_min ? v > r.min : v >= r.min);
}

}  // namespace lcrig
