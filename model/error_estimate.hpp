// SPDX-License-Identifier: Apache-2.0
// How wrong each level is, before it is used. The constants were fitted to the reference cases so
// that the estimate is above the true error and less than ten times it (docs/model.md, "Auto").
#pragma once

#include "model/level.hpp"

namespace lcrig {

// Relative error of bonded_modulus_Pa against the exact elastic disc.
double bonded_modulus_error(double poisson_ratio, double shape_factor);

// Discretization error of delta C at the level's mesh, small strains. FEM levels only.
double mesh_error(const Specimen& specimen, const LevelSettings& settings);

// Relative error of delta C at this pressure against the finite-strain continuum with the same
// boundary. Errors: the level cannot describe the specimen or the pressure at all.
Result<double> estimate_error(const Specimen& specimen, const LevelSettings& settings,
                              Pressure pressure);

}  // namespace lcrig
