// SPDX-License-Identifier: Apache-2.0
// The parts from which make_level_model builds a level.
#pragma once

#include <functional>
#include <memory>

#include "model/level.hpp"

namespace lcrig {

// Strain e = 1 - t/t0 of a layer of this material and thickness (m) under the pressure.
using LayerStrain = std::function<Result<double>(const Material&, double thickness_m, Pressure)>;

// A level in which the strain of a layer depends only on its material, its thickness and the
// pressure: `linear`, `hyperelastic` and `bonded`. The specimen must have passed check_specimen.
std::unique_ptr<LevelModel> make_layered_model(const Specimen& specimen, LayerStrain strain);

// Adds to any level the air that is left under the electrodes, as a gap in series with every
// capacitor. specimen.contact_gap must be set.
std::unique_ptr<LevelModel> with_contact_gap(const Specimen& specimen,
                                             std::unique_ptr<LevelModel> model);

// Adds to any level the fringe field of each capacitor. Each capacitor is treated alone, in a
// medium of its own permittivity. This gives an upper bound, because the plates of a stack shield
// each other. Errors: a gap outside 1e-4 to 100 radii.
Result<std::unique_ptr<LevelModel>> with_fringe(const Specimen& specimen,
                                                std::unique_ptr<LevelModel> model);

}  // namespace lcrig
