// SPDX-License-Identifier: Apache-2.0
// Delta C against pressure for one state of a specimen: a few solutions of the level, interpolated.
// A fit evaluates it at every datum.
#pragma once

#include <vector>

#include "model/level.hpp"

namespace lcrig {

class FitCurve {
 public:
  // Solves the level at Chebyshev points from 0 to `highest_Pa`. Errors: those of the level.
  static Result<FitCurve> solve(const Specimen& specimen, const LevelSettings& settings,
                                double highest_Pa);
  double at(double pressure_Pa) const;  // F; 0 for no pressure; a straight line beyond the highest
  double slope(double pressure_Pa) const;  // F/Pa
  double c0_F() const { return c0_F_; }  // of the model, unloaded

 private:
  double highest_Pa_ = 0, c0_F_ = 0;
  std::vector<double> place_, weight_;  // barycentric; places from 0 to 1
  std::vector<double> compliance_F_Pa_;  // delta C over pressure, which is smooth down to 0
};

}  // namespace lcrig
