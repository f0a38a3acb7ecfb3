// SPDX-License-Identifier: Apache-2.0
// Where a sequence of nested meshes leads: each cell is halved from one value to the next.
#pragma once

#include <vector>

namespace lcrig {

struct MeshLimit {
  double value = 0;  // Aitken's limit; of a sequence that has not settled the last value itself
  double doubt = 0;  // how far the limit may be off: what would be left at the least order
  double order = 0;  // observed, over the last steps; 0 when they change sign
  bool settled = false;  // each step is about half of the one before, or less
};

// `values` from coarse to fine, three or more; the last four count.
MeshLimit limit_of(const std::vector<double>& values);

}  // namespace lcrig
