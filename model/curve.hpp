// SPDX-License-Identifier: Apache-2.0
// C(P) of a specimen at one level. `lcrig model curve` prints it; reports, the design search and
// the comparison with the paper use it too.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "model/auto_level.hpp"

namespace lcrig {

inline constexpr std::size_t kMostPressures = 100'000;

// "0:100:10" (from, to, step) or "0,5,20", in kPa, rising, at most kMostPressures. The range
// includes its end when the step reaches it.
Result<std::vector<Pressure>> parse_pressures_kPa(std::string_view text);

struct ModelPoint {
  double pressure_Pa = 0, capacitance_F = 0, delta_capacitance_F = 0, shortening_m = 0;
  bool extrapolated = false;  // finite strain, which serves to rate the level, has no solution here
};

struct Curve {
  LevelSettings settings;
  // Relative, of delta C at the last pressure that is not extrapolated. Empty when the error of the
  // level is too large to be estimated.
  std::optional<double> error_estimate;
  std::optional<Pressure> lost_beyond;  // as in LevelChoice or ErrorEstimate
  std::optional<LevelChoice> choice;  // if calc_curve chose the level
  std::vector<ModelPoint> points;
};

// Without `settings` it takes the cheapest level within `tolerance`. Errors: as choose_level and
// the level itself; the message names the pressure.
Result<Curve> calc_curve(const Specimen& specimen, const std::optional<LevelSettings>& settings,
                         double tolerance, const std::vector<Pressure>& pressures,
                         const std::optional<SearchTime>& patience = std::nullopt);

nlohmann::json to_json(const Curve& curve);  // docs/cli-json.md, "model curve"

// Least-squares slope of delta C over pressure, F/Pa, with centred sums. Needs at least two points.
double fit_slope(const std::vector<ModelPoint>& points);

}  // namespace lcrig
