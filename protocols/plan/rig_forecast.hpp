// SPDX-License-Identifier: Apache-2.0
// Makes the forecast of a rig's motions from the facts about the rig. Used by the plan and by each
// run.
#pragma once

#include <string>
#include <vector>

#include "protocols/plan/check.hpp"
#include "protocols/rig/forecast.hpp"

namespace lcrig {

Forecast make_forecast(const Rig& rig);
// Assumptions behind the forecast, one line each. Plan and run state them.
std::vector<std::string> forecast_assumptions(const Rig& rig, const Forecast& forecast);

}  // namespace lcrig
