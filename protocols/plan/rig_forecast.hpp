// SPDX-License-Identifier: Apache-2.0
// Makes the forecast of a rig's motions from the facts known about the rig. The plan and each run
// use it.
#pragma once

#include <string>
#include <vector>

#include "protocols/plan/check.hpp"
#include "protocols/plan/forecast.hpp"

namespace lcrig {

Forecast make_forecast(const Rig& rig);
// Assumptions of the forecast, one line each, for plan and run.
std::vector<std::string> forecast_assumptions(const Rig& rig, const Forecast& forecast);

}  // namespace lcrig
