// SPDX-License-Identifier: Apache-2.0
// Adds the fringe field of each capacitor to any level. make_level_model uses it.
#pragma once

#include <memory>

#include "model/level.hpp"

namespace lcrig {

// Each capacitor is taken alone, in a medium of its own permittivity. This is an upper bound,
// because the plates of a stack shield each other. Errors: a gap outside 1e-4 to 100 radii.
Result<std::unique_ptr<LevelModel>> with_fringe(const Specimen& specimen,
                                                std::unique_ptr<LevelModel> model);

}  // namespace lcrig
