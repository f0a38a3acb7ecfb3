// SPDX-License-Identifier: Apache-2.0
// Any level with air left under the electrodes.
#pragma once

#include <memory>

#include "model/level.hpp"

namespace lcrig {

// specimen.contact_gap must be there. Every capacitor gets the gap in series.
std::unique_ptr<LevelModel> with_contact_gap(const Specimen& specimen,
                                             std::unique_ptr<LevelModel> model);

}  // namespace lcrig
