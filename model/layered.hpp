// SPDX-License-Identifier: Apache-2.0
// Builds a level in which the strain of a layer depends only on its material, its thickness and the
// pressure. level.cpp builds `linear`, `hyperelastic` and `bonded` this way.
#pragma once

#include <functional>
#include <memory>

#include "model/level.hpp"

namespace lcrig {

// Strain e = 1 - t/t0 of a layer of this material and thickness (m) under the pressure.
using LayerStrain = std::function<Result<double>(const Material&, double thickness_m, Pressure)>;

// The specimen must have passed check_specimen.
std::unique_ptr<LevelModel> make_layered_model(const Specimen& specimen, LayerStrain strain);

}  // namespace lcrig
