// SPDX-License-Identifier: Apache-2.0
// Adds the air left under the electrodes to any level. make_level_model uses it.
#pragma once

#include <memory>

#include "model/level.hpp"

namespace lcrig {

// Puts the gap in series with every capacitor. specimen.contact_gap must be set.
std::unique_ptr<LevelModel> with_contact_gap(const Specimen& specimen,
                                             std::unique_ptr<LevelModel> model);

}  // namespace lcrig
