// SPDX-License-Identifier: Apache-2.0
// Definitions that the analysis of a recorded run and the budget of a planned run share, so that
// both use words with the same meaning.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace lcrig {

// Relative difference up to which two pressures are the same.
constexpr double kNear = 0.02;
inline bool is_near(double kPa, double to_kPa) {
  return std::abs(kPa - to_kPa) <= kNear * std::abs(to_kPa);
}

struct PressureRange {
  double from_kPa = 0, to_kPa = 0;
  // If not empty: of the levels in the range only those near these pressures, each with the same
  // weight. So the slopes of two runs with different levels become slopes at the same pressures.
  std::vector<double> only_kPa = {};
};

// The edges belong to the range. Rounding is allowed for: a level at 30 kPa lies in 0-30 kPa.
inline bool is_inside(const PressureRange& range, double kPa) {
  const double slack = 1e-6 * std::max(std::abs(range.to_kPa), 1.0);
  if (!(kPa >= range.from_kPa - slack && kPa <= range.to_kPa + slack)) return false;
  return range.only_kPa.empty() ||
         std::ranges::any_of(range.only_kPa, [&](double p) { return is_near(kPa, p); });
}

// Share of the largest force at which a cycle begins on the way up and ends on the way down.
constexpr double kCycleEdge = 0.05;
// Readings of at least this share of a cycle's peak lie on its plateau, if they are enough.
constexpr double kPlateau = 0.98;
constexpr std::int64_t kPlateauReadings = 10;
constexpr double kPlateauTime_s = 2;
// Variance of a force that is interpolated between two samples, over the variance of one sample, as
// a mean over all places between them.
constexpr double kInterpolated = 2.0 / 3;
// Fewest readings from which the mean and scatter of a stretch without load are computed.
constexpr std::int64_t kLeastOfRest = 3;

// What an interval does not know.
inline constexpr const char* kOneCycle =
    "one cycle: the interval knows nothing of what differs between cycles";
inline constexpr const char* kOneRepeat =
    "one repeat: the interval knows nothing of what differs between repeats";

}  // namespace lcrig
