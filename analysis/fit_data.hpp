// SPDX-License-Identifier: Apache-2.0
// Prepares a run for the fit of a model: the levels in pieces, what the load's history leaves in
// each, the rests after a load, and the unloading branch. `lcrig model fit` uses it.
#pragma once

#include "analysis/analysis.hpp"
#include "model/fit.hpp"

namespace lcrig {

// Pressures are over the area of the disc. The data come from the branch with more levels. Errors:
// the area of the probe is not known; no level; no C0.
Result<FitData> fit_data_of(const RunData& run, const RunAnalysis& analysis, double disc_area_m2);

}  // namespace lcrig
