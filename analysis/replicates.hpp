// SPDX-License-Identifier: Apache-2.0
// How well a level and a slope are known from what was measured more than once: levels of several
// repeats, and readings within a level. The passes over levels and ranges use it. Private to
// analysis/.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis/metrics.hpp"

namespace lcrig {

// A level of a range: x in kPa, y in fF, weight = number of readings.
struct RangePoint {
  LinePoint at;
  LevelKey key;
  std::int32_t repeat = 0, level = 0;
  double t_s = 0;
  std::int64_t readings = 0, planned = 0;
  // In the slope. Whatever a repeat lacks, the levels count as they were planned, so that the slope
  // is that of the same curve.
  double line_weight = 0;
  double reading_ss = 0;  // sum of squares of the readings about their mean, fF2
  double trend_ss = 0;  // of which a straight line in time explains
  double pressure_ss = 0, cross_ss = 0;  // likewise of the pressures, kPa2, and with them, fF kPa
};

// Variance of a point of weight 1, and the degrees of freedom with which it is known.
struct PureError {
  double variance = 0, degrees_of_freedom = 0;
  std::string basis;
};

// y = slope x + effect of the level + effect of the repeat, by least squares with the weights of
// the points, from the levels that were measured in several repeats. A level that one of the
// repeats lacks is compared within the other repeats only.
struct AdditiveFit {
  double slope = 0, x = 0, y = 0;  // effects are above the line through (x, y)
  std::map<LevelKey, double> of_level;
  std::map<std::int32_t, double> of_repeat;  // their mean is 0
  double residual_ss = 0, freedom = 0;

  double above_line(const RangePoint& p) const { return (p.at.y - y) - slope * (p.at.x - x); }
};
AdditiveFit fit_additive(const std::vector<RangePoint>& points, double slope);
// The points less the effects of their repeats: a C0 that moved between repeats turns no slope,
// also where a repeat lacks a level.
std::vector<RangePoint> without_offsets(std::vector<RangePoint> points);
// Sets the weights in the slope from the planned readings; all together they weigh what they did.
void weigh_as_planned(std::vector<RangePoint>& points);

// From levels that were measured in several repeats: what is left after the effect of the level and
// of the repeat (a C0 that moved between repeats does no harm to a slope). `slope` takes out that
// the pressures of a level differ a little. Nothing: fewer than two repeats.
std::optional<PureError> error_between_repeats(const std::vector<RangePoint>& points, double slope);
// From the readings within the levels: of what they deviate from a line of this slope, so that the
// scatter of the force counts, and that of a force that the capacitance follows does not.
std::optional<PureError> error_within_levels(const std::vector<RangePoint>& points, double slope);
double reading_ss(const RangePoint& point, double slope);

RangePoint point_of(const MeasuredLevel& level, double fF);
RangePoint point_of(const LevelResult& level);
// Levels of the direction of the line.
std::vector<RangePoint> all_points(const LevelResults& levels);

// Variance of a point of weight 1 in the eyes of the slope: docs/analysis.md, "Which scatter".
//   The slopes of several repeats are a sample. The scatter of levels between repeats has more
// degrees of freedom and takes no part: a choice by size holds too often where repeats are alike.
// One repeat: its readings, with what neighbours know of each other. Falls back on the residuals of
// the line; nothing when there are as many points as the line has parameters.
struct SlopeScatter {
  PureError error;
  std::optional<PureError> of_slopes;  // repeats taken as one value each
  std::optional<PureError> of_levels;  // levels between repeats, or readings: knows no shape
  std::vector<double> slopes;  // of each repeat, fF/kPa
  bool one_repeat = false;  // nothing is known of what differs between repeats
};
std::optional<SlopeScatter> scatter_of_slope(const Scene& scene,
                                             const std::vector<RangePoint>& range,
                                             const std::vector<RangePoint>& whole_run,
                                             const LineFit& line);

}  // namespace lcrig
