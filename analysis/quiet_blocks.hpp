// SPDX-License-Identifier: Apache-2.0
// The readings without a load, as some forty blocks. Private to analysis/.
#pragma once

#include <vector>

#include "analysis/metrics.hpp"
#include "analysis/slow_noise.hpp"

namespace lcrig {

struct QuietBlocks {
  struct Of {
    std::size_t node = 0;
    double readings = 0;
  };
  std::vector<QuietBlock> blocks;  // in the order of time; Huber's location of their readings
  std::vector<std::vector<Of>> of_node;  // of each block: which nodes of the drift it is from
};
// Short rests of a run with many are taken together.
QuietBlocks cut_quiet_blocks(const Scene& scene);

}  // namespace lcrig
