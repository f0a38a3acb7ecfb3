// SPDX-License-Identifier: Apache-2.0
// Shear modulus and contact offset of a recorded run: what `lcrig model fit` prints.
#pragma once

#include <vector>

#include "base/quantity.hpp"
#include "model/level.hpp"

namespace lcrig {

struct FitPoint {
  double pressure_Pa = 0;  // over the disc
  double delta_capacitance_F = 0;
  double standard_error_F = 0;  // > 0: weights; 0 for all: equal weights
};

struct FitValue {
  double value = 0;
  double standard_error = 0;
  double ci95_low = 0, ci95_high = 0;  // Student's t
};

struct Fit {
  FitValue shear_modulus_Pa;  // of the soft layers; nu stays as given
  FitValue contact_offset_Pa;  // pressure that is spent before the faces touch all over
  double residual_F = 0;  // root mean square
  double correlation = 0;  // of the two estimates
  int points = 0, iterations = 0;
};

// delta C(P) = model(max(P - offset, 0); mu) by Gauss-Newton. One material that is not rigid and
// not a hundred times stiffer than another is taken as the soft one. Errors: fewer than four
// points; several soft materials; no convergence; a level that has no answer near the data.
Result<Fit> fit_response(const Specimen& specimen, const LevelSettings& settings,
                         const std::vector<FitPoint>& points);

// 97.5 % quantile of Student's t, degrees of freedom >= 1, to 1e-3.
double student_t975(int degrees_of_freedom);

}  // namespace lcrig
