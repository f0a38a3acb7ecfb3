// SPDX-License-Identifier: Apache-2.0
// Words that results get when all of them are known; private to analysis/.
#pragma once

#include "analysis/metrics.hpp"

namespace lcrig {

// Adds to the reasons of the metrics, and what the meter's digit adds to the uncertainties.
void add_remarks(const Scene& scene, RunAnalysis& analysis);

}  // namespace lcrig
