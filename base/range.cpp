// SPDX-License-Identifier: Apache-2.0
#include "base/range.hpp"

#include <fmt/core.h>

namespace lcrig {

std::string range_words(const Range& r, double unit) {
  const bool low = r.min > -1e299, high = r.max < 1e299;
  const double min = r.min / unit, max = r.max / unit;
  if (low && high && !r.open_min) return fmt::format("from {:.6g} to {:.6g}", min, max);
  if (low && high) return fmt::format("greater than {:.6g}, at most {:.6g}", min, max);
  if (low && r.open_min) return fmt::format("greater than {:.6g}", min);
  if (low) return fmt::format("at least {:.6g}", min);
  return fmt::format("at most {:.6g}", max);
}

bool contains(const Range& r, double v) {
  return v <= r.max && (r.open_min ? v > r.min : v >= r.min);
}

}  // namespace lcrig
