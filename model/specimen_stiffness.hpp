// SPDX-License-Identifier: Apache-2.0
// How far a specimen yields, according to its file. The daemon uses it to plan runs.
#pragma once

#include <functional>
#include <optional>

#include "base/quantity.hpp"
#include "model/specimen.hpp"

namespace lcrig {

// Between any two forces over the disc the specimen shortens by at least as much as this does, m.
// Every layer is as stiff as it can be at its force: as if it could not move sideways (uniaxial
// strain), or as if nothing held it (uniaxial stress). The latter is stiffer where it is flat: at
// the same force it has been pressed deeper. Whatever holds it partly lies between the two. Each
// strain energy counts, and each modulus that the file states. Rigid layers do not give way at all,
// nor do incompressible ones while they cannot move sideways.
std::function<double(double force_N)> least_shortening(const Specimen& specimen);

// The shortening with nothing that holds the layers sideways: it stiffens more than any other.
std::function<double(double force_N)> free_shortening(const Specimen& specimen);

// Expected travel beyond contact, for specimen and frame in series, by the cheapest level that
// applies. Empty when no cheap level describes this specimen.
std::function<double(double force_N)> expected_compression(
    const Specimen& specimen, Force force_max, std::optional<double> frame_stiffness_N_m);

}  // namespace lcrig
