// SPDX-License-Identifier: Apache-2.0
// The functions behind the rows of the table.
#pragma once

#include "protocols/checks/check.hpp"

namespace lcrig::checks {

using Found = std::optional<std::string>;

// frozen.cpp
Found frozen_digits(const RigState& rig, const Sight& sight);
// travel.cpp
Found place_after_motion(const RigState& rig, const Sight& sight);
Found against_order(const RigState& rig, const Sight& sight);
Found ahead_of_order(const RigState& rig, const Sight& sight);
Found moves_at_standstill(const RigState& rig, const Sight& sight);
Found stalls(const RigState& rig, const Sight& sight);
Found loop_without_force(const RigState& rig, const Sight& sight);
Found loop_runs_away(const RigState& rig, const Sight& sight);
// force.cpp
Found force_falls(const RigState& rig, const Sight& sight);
Found force_too_small(const RigState& rig, const Sight& sight);
Found force_rises(const RigState& rig, const Sight& sight);
Found prediction_exceeded(const RigState& rig, const Sight& sight);
Found shown_late(const RigState& rig, const Sight& sight);
// jump.cpp
Found force_jumps(const RigState& rig, const Sight& sight);
// sign.cpp
Found sign_changed(const RigState& rig, const Sight& sight);
Found pulls_without_retreat(const RigState& rig, const Sight& sight);
// limits.cpp
Found force_limit(const RigState& rig, const Sight& sight);
Found travel_limit(const RigState& rig, const Sight& sight);
Found beyond_cell(const RigState& rig, const Sight& sight);
Found force_on_retreat(const RigState& rig, const Sight& sight);
Found travel_on_retreat(const RigState& rig, const Sight& sight);
Found blind_retreat(const RigState& rig, const Sight& sight);
// silence.cpp
Found no_travel(const RigState& rig, const Sight& sight);
Found no_force(const RigState& rig, MonoTime now);

}  // namespace lcrig::checks
