// SPDX-License-Identifier: Apache-2.0
// Any level with the fringe field of each capacitor added.
#pragma once

#include <memory>

#include "model/level.hpp"

namespace lcrig {

// Each capacitor is taken alone in a medium of its own permittivity: an upper bound, since the
// plates of a stack shield each other. Errors: a gap beyond a hundred radii.
Result<std::unique_ptr<LevelModel>> with_fringe(const Specimen& specimen,
                                                std::unique_ptr<LevelModel> model);

}  // namespace lcrig
