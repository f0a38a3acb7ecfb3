// SPDX-License-Identifier: Apache-2.0
// Whether a motion may start: the worst force that it can reach, by the upper edge of the force
// corridor (Forecast), against the limits. Pure functions of the state of the rig.
#pragma once

#include "base/result.hpp"
#include "protocols/rig/rig_state.hpp"

namespace lcrig {

// Errors of all: invalid_request, with the speed that would be allowed; limit_tripped. Nothing has
// moved. The frame must be one that can move.
Result<Permit> permit_to_force(const RigState& rig, double force_N, double speed_m_s);
Result<Permit> permit_to_travel(const RigState& rig, double travel_m, double speed_m_s);
Result<Permit> permit_ramp(const RigState& rig, double force_N, double rate_N_s);
// Motion away from the specimen, with unchanged limits.
Permit permit_retreat(const RigState& rig);

// Whether a contact of this stiffness explains that a motion, ordered to stop at `force_N`, ended
// at `felt_N`. All forces are beyond zero.
bool explains(const RigState& rig, double felt_N, double stiffness_N_m, double force_N,
              double speed_m_s);

}  // namespace lcrig
