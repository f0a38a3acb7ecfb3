// SPDX-License-Identifier: Apache-2.0
// Calculates the stiffness of a contact from looks at a standing frame on its way out of contact.
// Used by the contact probe.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "protocols/rig/rest_measurement.hpp"

namespace lcrig {

// The best estimate, and the largest and smallest stiffness that the looks allow, N/m.
struct ContactSlope {
  double about = 0, at_most = 0, at_least = 0;
  double doubt() const { return at_most - at_least; }
};

struct RetreatFacts {
  double felt_N = 0;  // at contact
  double drift_N_s = 0;  // possible drift of the cell's zero, in either direction
  double relaxes_N_s =
      0;  // the fastest fall of the force before the first step, at constant travel
  double resolution_m = 0;  // of a way: the first step back, or the step of the travel
};

// `looks`: at contact, and after each step back. In the first `touching` of them the probe presses.
// nullopt: no stiffness can be given, or the looks contradict each other.
//
// A drive may have lost motion: the first part of its way back moves nothing, so a slope that
// begins at contact is less than the stiffness. Such a slope therefore counts only if the force
// fell from the beginning, and no upper bound may be below what a later part of the way proves.
// The force of a specimen that relaxes falls in the lost motion, too. A relaxation only slows down,
// so a fall counts only if it is faster than every one before it allows.
std::optional<ContactSlope> contact_slope(std::span<const RestMeasurement> looks,
                                          std::size_t touching, const RetreatFacts& facts);

// The stiffness that these looks prove at least, whatever play or relaxation there is; 0: none. It
// needs no slope: the force has fallen on the way back, by more than relaxation explains.
double proven_stiffness_N_m(std::span<const RestMeasurement> looks, const RetreatFacts& facts);

// From the begin of one look to that of the other; 0 if unknown.
double seconds_between(const RestMeasurement& a, const RestMeasurement& b);

// The fastest fall of the force from one look to a later one that errors allow, N/s; infinite if
// their times are unknown.
double fastest_fall_N_s(const RestMeasurement& from, const RestMeasurement& to);

}  // namespace lcrig
