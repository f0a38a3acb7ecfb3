// SPDX-License-Identifier: Apache-2.0
// How far a specimen yields, according to its file. The daemon uses it to plan runs.
#pragma once

#include <functional>
#include <optional>

#include "base/quantity.hpp"
#include "model/specimen.hpp"

namespace lcrig {

// A lower bound of the shortening under a force over the disc, m. Every layer is assumed to be held
// sideways (uniaxial strain, confined neo-Hookean), because nothing that holds its faces can make
// it stiffer. Rigid and incompressible layers do not yield at all.
std::function<double(double force_N)> least_shortening(const Specimen& specimen);

// Expected travel beyond contact, for specimen and frame in series, by the cheapest level that
// applies. Empty when no cheap level describes this specimen.
std::function<double(double force_N)> expected_compression(
    const Specimen& specimen, Force force_max, std::optional<double> frame_stiffness_N_m);

}  // namespace lcrig
