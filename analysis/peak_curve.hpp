// SPDX-License-Identifier: Apache-2.0
// The curve through the upper half of a loading and an unloading. Its first parameter is C at the
// peak. The analysis fits it, and the budget predicts the scatter of the fit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace lcrig {

class PeakCurve {
 public:
  static constexpr double kUpper = 0.5;  // share of the peak force above which readings take part

  PeakCurve(std::int64_t up, std::int64_t down)
      : branches_(up >= 2 && down >= 2),
        bend_(up + down >= 8),
        own_bends_(up >= kMany && down >= kMany) {}
  std::size_t columns() const {
    if (own_bends_) return 6;
    return 1 + (branches_ ? 2U : 1U) + (bend_ ? 1U : 0U);
  }
  // `d`: force over peak force, less 1.
  std::array<double, 6> row(double d, bool rising) const {
    const double d2 = d * d;
    if (own_bends_) {
      return {1, rising ? d : 0, rising ? 0 : d, rising ? d2 : 0, rising ? 0 : d2, d2 * d};
    }
    if (branches_) return {1, rising ? d : 0, rising ? 0 : d, d2, 0, 0};
    return {1, d, d2, 0, 0, 0};
  }

 private:
  static constexpr std::int64_t kMany = 16;  // readings of a branch that suffice for its own bend
  bool branches_, bend_, own_bends_;
};

}  // namespace lcrig
