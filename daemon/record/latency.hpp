// SPDX-License-Identifier: Apache-2.0
// A histogram of durations in constant memory, for percentiles of a whole run. The recorder
// measures its commits with it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "base/time.hpp"

namespace lcrig {

// Buckets grow by 1/16 of a power of two. Percentiles are exact within 6.3 % (upper edge), the
// maximum exactly.
class LatencyHistogram {
 public:
  void add(Duration d) {
    const auto ns = static_cast<std::uint64_t>(d.count() > 0 ? d.count() : 0);
    ++counts_[bucket_of(ns)];
    ++total_;
    if (d > max_) max_ = d;
  }
  std::uint64_t count() const { return total_; }
  Duration max() const { return max_; }
  // Fraction 0..1; 0 ns when nothing was added.
  Duration percentile(double fraction) const {
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      seen += counts_[i];
      if (seen > 0 && static_cast<double>(seen) >= fraction * static_cast<double>(total_)) {
        return std::min(upper_edge(i), max_);
      }
    }
    return max_;
  }

 private:
  static constexpr unsigned kSteps = 16;  // per power of two
  static std::size_t bucket_of(std::uint64_t ns) {
    if (ns < kSteps) return ns;
    const auto shift = static_cast<unsigned>(std::bit_width(ns)) - 5;  // ns >> shift is 16..31
    return kSteps * shift + static_cast<std::size_t>(ns >> shift);
  }
  static Duration upper_edge(std::size_t bucket) {
    if (bucket < kSteps) return Duration(bucket);
    const std::size_t shift = bucket / kSteps - 1;
    return Duration(((bucket - kSteps * shift + 1) << shift) - 1);
  }
  std::array<std::uint64_t, kSteps * 61> counts_{};
  std::uint64_t total_ = 0;
  Duration max_{};
};

}  // namespace lcrig
