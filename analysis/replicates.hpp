// SPDX-License-Identifier: Apache-2.0
// Pure error: the scatter of points that ought to be equal, whatever the shape of the curve.
// Private to analysis/.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/metrics.hpp"

namespace lcrig {

// A level of a range: x in kPa, y in fF, weight = number of readings.
struct RangePoint {
  LinePoint at;
  LevelKey key;
  std::int32_t repeat = 0;
  double t_s = 0;
  std::int64_t readings = 0;
  double reading_ss = 0;  // sum of squares of the readings about their mean, fF2
};

// Variance of a point of weight 1, and the degrees of freedom with which it is known.
struct PureError {
  double variance = 0, degrees_of_freedom = 0;
  std::string basis;
};

// From levels that were measured in several repeats: what is left after the effect of the level and
// of the repeat (a C0 that moved between repeats does no harm to a slope). `slope` takes out that
// the pressures of a level differ a little. Nothing: fewer than two repeats.
std::optional<PureError> error_between_repeats(const std::vector<RangePoint>& points, double slope);
// From the readings within the levels.
std::optional<PureError> error_within_levels(const std::vector<RangePoint>& points);

// The choice: docs/analysis.md, "Which scatter". Falls back on the residuals of the line; nothing
// when there are as many points as the line has parameters.
std::optional<PureError> choose_error(const std::vector<RangePoint>& range,
                                      const std::vector<RangePoint>& whole_run,
                                      const LineFit& line);

}  // namespace lcrig
