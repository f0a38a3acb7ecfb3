// SPDX-License-Identifier: Apache-2.0
// Fits shear modulus, contact offset and C0 to a recorded run. `lcrig model fit` prints it.
#pragma once

#include <cstdint>
#include <limits>
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
  double pressure_Pa = 0;  // force over the area of the disc
  double delta_capacitance_F = 0;
  double standard_error_F = 0;  // gives the weight; 0 for all points: equal weights
  std::int32_t repeat = 0;  // the points of one repeat may share errors
};

struct C0Error {
  C0Error() = default;
  explicit C0Error(double error, double freedom = std::numeric_limits<double>::infinity())
      : standard_error_F(error), degrees_of_freedom(freedom) {}
  double standard_error_F = 0;  // 0: C0 is not fitted
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};

struct FitValue {
  double value = 0;
  double standard_error = 0;
  double ci95_low = 0, ci95_high = 0;  // Student's t
  // How far the value moves when the model's delta C has a relative error of 1 everywhere.
  // Multiplied by the estimated error of the level it gives the model's part of the uncertainty.
  double per_model_error = 0;
};

struct Fit {
  FitValue shear_modulus_Pa;  // of the soft layers; nu stays as given
  // Zero of the cell, plus the pressure that is needed before the faces touch everywhere. A fit
  // cannot separate the two.
  FitValue contact_offset_Pa;
  // true C0 less the C0 that was subtracted for delta C; 0 when it is not fitted
  FitValue c0_shift_F;
  double residual_F = 0;  // root mean square
  double correlation = 0;  // of modulus and offset
  int points = 0, iterations = 0;
  int repeats = 0;  // repeats behind the standard errors; 0: residuals are behind them
};

// Fits delta C(P) = model(max(P - offset, 0); mu) + shift by Gauss-Newton. The specimen must have
// exactly one soft material: not rigid, and not a hundred times stiffer than another. `c0` is the
// error of the C0 that was subtracted for delta C. All points share this error, so the shift is
// fitted if it is above 0. Standard errors come from the repeats as a sample, plus that of C0; with
// one repeat they come from the residuals. Errors: fewer than four points (five with a shift);
// several soft materials; no convergence; a level that has no answer near the data.
Result<Fit> fit_response(const Specimen& specimen, const LevelSettings& settings,
                         const std::vector<FitPoint>& points, const C0Error& c0 = {});

// 97.5 % quantile of Student's t. Less than one degree of freedom counts as one.
double student_t975(int degrees_of_freedom);

}  // namespace lcrig
