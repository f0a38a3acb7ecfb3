// SPDX-License-Identifier: Apache-2.0
// The readings without a load in some forty blocks, to estimate slow noise. Private to analysis/.
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
  std::vector<QuietBlock> blocks;  // in the order of time; Huber's locations
  std::vector<std::vector<Of>> of_node;  // for each block: the nodes that its readings are from
};
// If a run has many short rests, several of them form one block.
QuietBlocks cut_quiet_blocks(const Scene& scene);

}  // namespace lcrig
