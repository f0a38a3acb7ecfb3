// SPDX-License-Identifier: Apache-2.0
// Puts a comparison into one sentence that a paper can quote. Private to analysis/.
#pragma once

#include <optional>
#include <string>

#include "analysis/comparison.hpp"

namespace lcrig {

struct VerdictScope {
  std::string quantity;  // "sensitivity"
  std::string where;  // "0-30 kPa"; of the dynamic range its peak; empty: nowhere in particular
  std::optional<Direction> direction;
  double confidence = kConfidence;
  std::string from_origin, to_origin;  // "simulated", "replayed"; empty: measured
};
// "paper-2 is 1.96 to 2.04 times as sensitive as paper-1 in 0-30 kPa, same probe, loading branch
// (95 %)"; of a refused comparison the reason and the remedy.
std::string verdict_on(const Comparison& comparison, const VerdictScope& scope);

// Both ends with as many digits as the width needs, rounded outwards.
std::string ratio_text(double low, double high);

}  // namespace lcrig
