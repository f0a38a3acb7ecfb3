// SPDX-License-Identifier: Apache-2.0
// How stiff a contact is, from looks at a frame that stands, on a way out of it. Used by the probe.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "protocols/watch/rest.hpp"

namespace lcrig {

constexpr double kSlopeSigmas = 3;  // of a bound

// The best guess, and the largest and least stiffness that the looks allow, N/m.
struct ContactSlope {
  double about = 0, at_most = 0, at_least = 0;
  double doubt() const { return at_most - at_least; }
};

// `looks`: where it touched with a force of `felt_N`, and after each step back; the first
// `touching` of them press. `drift_N_s`: how fast the cell's zero may go away, in either direction.
// nullopt: nothing can be told, or the looks contradict each other.
//
// A drive may have lost motion: the first part of its way back moves nothing, and a slope that
// begins where it touched is less than that of the contact. So a slope from there counts only
// where the force fell from the beginning, and no bound may be less than what a later part of the
// way proves.
std::optional<ContactSlope> contact_slope(std::span<const Rest> looks, std::size_t touching,
                                          double felt_N, double drift_N_s);

}  // namespace lcrig
