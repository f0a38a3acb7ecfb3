// SPDX-License-Identifier: Apache-2.0
// The area that the pressures of a stored run belong to. Analysis, report, export and fit use it.
#pragma once

#include "base/pressure_area.hpp"
#include "storage/runs.hpp"

namespace lcrig {

// From the probe, the specimen and the protocol that are stored with the run. What they do not say
// is not known: a run without a specimen has no disc.
PressureArea pressure_of_run(const RunRow& row);

}  // namespace lcrig
