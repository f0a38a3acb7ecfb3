// SPDX-License-Identifier: Apache-2.0
// Definitions that the analysis of a run and the budget of a planned run share, so that both mean
// the same by the same words.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace lcrig {

struct PressureRange {
  double from_kPa = 0, to_kPa = 0;
};

// The edges belong to a range, and are rounded: a level at 30 kPa lies in 0-30 kPa.
inline bool is_inside(const PressureRange& range, double kPa) {
  const double slack = 1e-6 * std::max(std::abs(range.to_kPa), 1.0);
  return kPa >= range.from_kPa - slack && kPa <= range.to_kPa + slack;
}

// A cycle begins and ends where the force leaves and reaches this share of the largest.
constexpr double kCycleEdge = 0.05;
// Readings of at least this share of a cycle's peak lie on its plateau, if there are enough.
constexpr double kPlateau = 0.98;
constexpr std::int64_t kPlateauReadings = 10;
constexpr double kPlateauTime_s = 2;
// A reading's force lies between two samples: over all places the variance is 2/3 of a sample's.
constexpr double kInterpolated = 2.0 / 3;
// Readings of a stretch without load that tell its mean and scatter.
constexpr std::int64_t kLeastOfRest = 3;

}  // namespace lcrig
