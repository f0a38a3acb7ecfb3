// SPDX-License-Identifier: Apache-2.0
// Shear modulus, contact offset and C0 of a recorded run: what `lcrig model fit` prints.
#pragma once

#include <cstdint>
#include <vector>

#include "base/quantity.hpp"
#include "model/level.hpp"

namespace lcrig {

struct FitPoint {
  FitPoint() = default;
  FitPoint(double pressure, double delta_capacitance, double error = 0, std::int32_t of_repeat = 0)
      : pressure_Pa(pressure),
        delta_capacitance_F(delta_capacitance),
        standard_error_F(error),
        repeat(of_repeat) {}
  double pressure_Pa = 0;  // over the disc
  double delta_capacitance_F = 0;
  double standard_error_F = 0;  // > 0: weights; 0 for all: equal weights
  std::int32_t repeat = 0;  // points of one repeat may err together
};

struct FitValue {
  double value = 0;
  double standard_error = 0;
  double ci95_low = 0, ci95_high = 0;  // Student's t
  // By what the value moves when the model's delta C is wrong by a share of 1 everywhere: times the
  // estimated error of the level, what the model adds to the uncertainty.
  double per_model_error = 0;
};

struct Fit {
  FitValue shear_modulus_Pa;  // of the soft layers; nu stays as given
  // Zero of the cell, and pressure that is spent before the faces touch all over: the two act
  // alike.
  FitValue contact_offset_Pa;
  FitValue c0_shift_F;  // true C0 less the one that delta C was taken from; 0 when it is not fitted
  double residual_F = 0;  // root mean square
  double correlation = 0;  // of modulus and offset
  int points = 0, iterations = 0;
  int repeats = 0;  // whose differences the standard errors know; 0: the residuals' only
};

// delta C(P) = model(max(P - offset, 0); mu) + shift by Gauss-Newton. One material that is not
// rigid and not a hundred times stiffer than another is taken as the soft one.
// `c0_standard_error_F`, of the C0 that delta C was taken from and in the unit of the points'
// weights: above 0, the shift is fitted, because all points share that error. Standard errors come
// from the residuals, or from what repeats differ by where that is more. Errors: fewer than four
// points (five with a shift); several soft materials; no convergence; a level that has no answer
// near the data.
Result<Fit> fit_response(const Specimen& specimen, const LevelSettings& settings,
                         const std::vector<FitPoint>& points, double c0_standard_error_F = 0);

// 97.5 % quantile of Student's t, degrees of freedom >= 1, to 1e-3.
double student_t975(int degrees_of_freedom);

}  // namespace lcrig
