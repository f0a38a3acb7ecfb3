// SPDX-License-Identifier: Apache-2.0
// Chooses the ticks of an axis: round numbers, with labels of equal decimals. Used by layout.
#pragma once

#include <string>
#include <vector>

namespace lcrig::plot {

struct Ticks {
  std::vector<double> at;
  std::vector<std::string> labels;
  std::vector<double> minor;  // without a label
};

// Multiples of 1, 2, 2.5 or 5 times a power of ten within [low, high], at most `most` (>= 2).
// Precondition: low < high, finite.
Ticks linear_ticks(double low, double high, int most);
// Powers of ten. Over less than two decades also 2 and 5 times these; when that gives too few, as
// linear_ticks. Precondition: 0 < low < high.
Ticks log_ticks(double low, double high, int most);

}  // namespace lcrig::plot
