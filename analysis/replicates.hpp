// SPDX-License-Identifier: Apache-2.0
// Determines how well a level and a slope are known from repeated measurements: levels of several
// repeats, and readings within a level. The passes over levels and ranges use it. Private to
// analysis/.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis/metrics.hpp"

namespace lcrig {

// A level of a range. x is in kPa, y in fF; the weight is the number of readings.
struct RangePoint {
  LinePoint at;
  LevelKey key;
  std::int32_t repeat = 0, level = 0;
  double t_s = 0;
  std::int64_t readings = 0, planned = 0;
  // Weight in the slope, from the planned number of readings. If a repeat lacks readings, the slope
  // then still is that of the same curve.
  double line_weight = 0;
  double reading_ss = 0;  // sum of squares of the readings about their mean, fF2
  double trend_ss = 0;  // the part of it that a straight line in time explains
  double pressure_ss = 0, cross_ss = 0;  // sums of squares, kPa2, and of products, fF kPa
};

// Variance of a point of weight 1, and its degrees of freedom.
struct PureError {
  double variance = 0, degrees_of_freedom = 0;
  std::string basis;
};

// The model y = slope x + effect of the level + effect of the repeat. It is fitted by least squares
// with the weights of the points to the levels that several repeats measured. A level that one
// repeat lacks is compared within the other repeats only.
struct AdditiveFit {
  double slope = 0, x = 0, y = 0;  // effects are relative to the line through (x, y)
  std::map<LevelKey, double> of_level;
  std::map<std::int32_t, double> of_repeat;  // their mean is 0
  double residual_ss = 0, freedom = 0;

  double above_line(const RangePoint& p) const { return (p.at.y - y) - slope * (p.at.x - x); }
};
AdditiveFit fit_additive(const std::vector<RangePoint>& points, double slope);
// The points with the effects of their repeats subtracted. A C0 that moved between repeats then
// does not tilt the slope, even where a repeat lacks a level.
std::vector<RangePoint> without_offsets(std::vector<RangePoint> points);
// Sets the weights in the slope according to the planned readings. Their sum stays the same.
void weigh_as_planned(std::vector<RangePoint>& points);

// The scatter of levels that several repeats measured, after the effects of level and repeat are
// taken out. (A C0 that moves between repeats does not affect a slope.) `slope` corrects for the
// small differences between the pressures of a level. Empty: fewer than two repeats.
std::optional<PureError> error_between_repeats(const std::vector<RangePoint>& points, double slope);
// The scatter of the readings within the levels about a line of this slope. It includes the scatter
// of the force, but not those changes of force that the capacitance follows.
std::optional<PureError> error_within_levels(const std::vector<RangePoint>& points, double slope);
double reading_ss(const RangePoint& point, double slope);

RangePoint point_of(const MeasuredLevel& level, double fF);
RangePoint point_of(const LevelResult& level);
// All levels of the direction through which the line goes.
std::vector<RangePoint> all_points(const LevelResults& levels);

// Variance of a point of weight 1 that is relevant for the slope: docs/analysis.md, "Which
// scatter".
//   With several repeats their slopes are treated as a sample. The scatter of levels between
// repeats has more degrees of freedom but takes no part: choosing the larger of the two would make
// intervals too wide where repeats are alike. With one repeat the scatter of its readings counts,
// corrected for the correlation of neighbours. The last resort is the residuals of the line. The
// result is empty when the line has no more points than parameters.
struct SlopeScatter {
  PureError error;
  std::optional<PureError> of_slopes;  // from the slopes of the repeats, each taken as one value
  std::optional<PureError> of_levels;  // from levels or readings; free of the curve's shape
  std::vector<double> slopes;  // fF/kPa, one for each repeat
  bool one_repeat = false;  // differences between repeats are then unknown
};
std::optional<SlopeScatter> scatter_of_slope(const Scene& scene,
                                             const std::vector<RangePoint>& range,
                                             const std::vector<RangePoint>& whole_run,
                                             const LineFit& line);

}  // namespace lcrig
