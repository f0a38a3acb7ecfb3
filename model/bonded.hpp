// SPDX-License-Identifier: Apache-2.0
// Apparent modulus of a disc bonded on both faces, averaged over its thickness: plane sections stay
// plane and the side bulges as a parabola. docs/model.md, "Bonded layer". Used by the level
// `bonded` and by the search for a design.
#pragma once

#include "base/quantity.hpp"
#include "base/result.hpp"

namespace lcrig {

// 8/x^2 times I2(x)/I0(x) with modified Bessel functions, x >= 0. It is 1 at 0 and falls like
// 8/x^2. Nothing overflows and no difference is taken. Relative error below 1e-14.
double bessel_bulge(double x);

// E_a, Pa. shape_factor S = radius/(2 thickness) > 0, poisson_ratio 0 to 0.5. At 0.5 the result is
// E (1 + 2 S^2). Within 2.9 % of the exact modulus for S = 0.5 to 80, and 0.2 % from S = 40.
double bonded_modulus_Pa(double shear_modulus_Pa, double poisson_ratio, double shape_factor);

// Strain of the nonlinear form: the confined neo-Hookean strain (form A, dead pressure) times the
// ratio of the confined to the apparent modulus. Errors: as solve_stretch.
Result<double> bonded_strain(Pressure shear_modulus, double poisson_ratio, double shape_factor,
                             Pressure pressure);

}  // namespace lcrig
