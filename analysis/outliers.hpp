// SPDX-License-Identifier: Apache-2.0
// Finds the readings that stand out: from their level less its drift, or in a loading without
// levels from their neighbours. Private to analysis/.
#pragma once

#include <vector>

#include "analysis/metrics.hpp"

namespace lcrig {

// Whether a reading belongs to its level.
bool counts_in_level(const RunView& view, const RunReading& r);
// Also finds the drift within the levels.
void find_outliers_of_levels(const RunView& view, const Rests& rests, MeasuredLevels& out);
void find_outliers_of_loadings(const RunView& view, const Rests& rests, Outliers& out);
void keep_largest_outliers(std::vector<Outlier>& outliers);

}  // namespace lcrig
