// SPDX-License-Identifier: Apache-2.0
// The best cut of a block into layers, where the position of a layer decides its contribution. Used
// by the design search.
#pragma once

#include <functional>
#include <vector>

namespace lcrig {

struct PartitionRequest {
  int layers = 1;  // 1 to 100
  double total_m = 0, least_m = 0;  // layers * least <= total
};

// Sensitivity that the layer between two heights (m above the base) adds, F/Pa.
using LayerSensitivity = std::function<double(double from_m, double to_m)>;

struct FoundPartition {
  std::vector<double> thickness_m;  // base to top
  double sensitivity_F_Pa = 0;
  double grid_m = 0;  // every partition on this grid was considered, including the vertices
};

// Finds the global optimum over a grid of thicknesses (dynamic programming). Then it moves
// boundaries off the grid, one by one, while that improves the result. The result is never worse
// than the best on the grid.
FoundPartition best_partition(const PartitionRequest& request, const LayerSensitivity& sensitivity);

}  // namespace lcrig
