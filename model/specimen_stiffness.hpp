// SPDX-License-Identifier: Apache-2.0
// What the file of a specimen says of how far it gives way, for the plan of a run.
#pragma once

#include <functional>
#include <optional>

#include "base/quantity.hpp"
#include "model/specimen.hpp"

namespace lcrig {

// Shortening under a force over the disc, m, at least: every layer as if it could not move sideways
// (uniaxial strain, confined neo-Hookean; whatever holds its faces, it cannot be stiffer). Rigid
// layers, and incompressible ones, do not give way at all.
std::function<double(double force_N)> least_shortening(const Specimen& specimen);

// Travel beyond contact as the cheapest level of the model has it, specimen and frame in series;
// empty when no cheap level describes this specimen.
std::function<double(double force_N)> expected_compression(
    const Specimen& specimen, Force force_max, std::optional<double> frame_stiffness_N_m);

}  // namespace lcrig
