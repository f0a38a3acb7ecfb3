// SPDX-License-Identifier: Apache-2.0
// The best cut of a block into layers, when what a layer contributes depends on where it lies.
#pragma once

#include <functional>
#include <vector>

namespace lcrig {

struct PartitionRequest {
  int layers = 1;  // 1 to 100
  double total_m = 0, least_m = 0;  // layers * least <= total
};

// What the layer between two heights (m, base 0) adds to the sensitivity, F/Pa.
using LayerSensitivity = std::function<double(double from_m, double to_m)>;

struct FoundPartition {
  std::vector<double> thickness_m;  // base to top
  double sensitivity_F_Pa = 0;
  double grid_m = 0;  // every partition on this grid was considered, vertices among them
};

// The global optimum over a grid of thicknesses (dynamic programming), then moved off the grid
// boundary by boundary while that improves it. Never below the best on the grid.
FoundPartition best_partition(const PartitionRequest& request, const LayerSensitivity& sensitivity);

}  // namespace lcrig
