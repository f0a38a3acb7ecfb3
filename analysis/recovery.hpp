// SPDX-License-Identifier: Apache-2.0
// A specimen that creeps recovers after each load, which moves the capacitance at rest as a drift
// of the rig does. Only the drift may be subtracted from a result under load. Private to analysis/.
#pragma once

#include <optional>
#include <vector>

#include "analysis/metrics.hpp"

namespace lcrig {

// The drift from the rests after loads alone, whose recovery differs less from rest to rest than
// from the baseline, which has none. nullopt: it takes a baseline and two such rests.
std::optional<Drift> drift_of_rests(const Scene& scene);

// Puts the drift of the rests after loads in the place of what was subtracted from the cycles.
// Returns the errors that are left in the mean of their delta C, fF: that of the rate, and what of
// the drift may still be recovery (limits, rectangular).
struct DriftLeft {
  SlopePart rate, recovery;
};
DriftLeft take_out_recovery(const Scene& scene, const Metric& creep,
                            std::vector<CycleResult>& cycles);

}  // namespace lcrig
