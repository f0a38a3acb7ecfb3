// SPDX-License-Identifier: Apache-2.0
// Capacitance of deformed layers: local parallel plates, integrated over the electrode. Both
// finite-element levels use it.
#pragma once

#include <vector>

#include "base/result.hpp"
#include "model/fem_space.hpp"

namespace lcrig {

// Change of each capacitor, F, computed from the changes of thickness. u is by equation. It is
// multiplied by `scale`, because linear problems are solved once for unit pressure. Errors: a layer
// has closed somewhere.
Result<std::vector<double>> capacitance_changes(
    const StackSpace& space, const std::vector<StackSpace::Capacitor>& capacitors,
    const std::vector<double>& u, double scale, ElectrodeArea area);

}  // namespace lcrig
