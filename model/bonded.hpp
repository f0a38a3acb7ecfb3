// SPDX-License-Identifier: Apache-2.0
// A disc bonded on both faces: apparent modulus, thickness-averaged (plane sections stay plane, the
// side bulges as a parabola). docs/model.md, section "Bonded layer".
#pragma once

#include "base/quantity.hpp"
#include "base/result.hpp"

namespace lcrig {

// I2(x)/I0(x) of modified Bessel functions times 8/x^2, x >= 0: 1 at 0, falls like 8/x^2. No
// function overflows and no difference is taken. Relative error below 1e-14.
double bessel_bulge(double x);

// E_a, Pa. shape_factor = radius/(2 thickness) > 0, poisson_ratio 0 to 0.5. At 0.5 it is
// E (1 + 2 S^2). Within 2.9 % of the exact one for S = 0.5 to 80, 0.2 % from S = 40.
double bonded_modulus_Pa(double shear_modulus_Pa, double poisson_ratio, double shape_factor);

// Strain of the nonlinear form: confined neo-Hookean strain (form A, dead pressure) times the ratio
// of the confined to the apparent modulus. Errors: as solve_stretch.
Result<double> bonded_strain(Pressure shear_modulus, double poisson_ratio, double shape_factor,
                             Pressure pressure);

}  // namespace lcrig
