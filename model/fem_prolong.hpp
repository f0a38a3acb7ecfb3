// SPDX-License-Identifier: Apache-2.0
// Carries a solution to a finer mesh of the same stack, where it is a good start for Newton's
// method. Used by fem_finite.
#pragma once

#include "model/fem_space.hpp"
#include "model/fem_system.hpp"

namespace lcrig {

// The state of `coarse`, interpolated at the nodes and in the cells of `fine`.
FemState prolong(const StackSpace& coarse, const FemState& state, const StackSpace& fine);

}  // namespace lcrig
