// SPDX-License-Identifier: Apache-2.0
// The limit of a sequence of nested meshes, in which each mesh halves every cell of the one before.
// Used by the error estimates.
#pragma once

#include <vector>

namespace lcrig {

struct MeshLimit {
  double value = 0;  // Aitken's limit, or the last value if the sequence has not settled
  double doubt = 0;  // how far the limit may be off, if the order is the least that is allowed for
  double order = 0;  // observed, over the last steps; 0 when they change sign
  bool settled = false;  // each step is about half of the one before, or less
};

// `values` from coarse to fine, at least three; only the last four count.
MeshLimit limit_of(const std::vector<double>& values);

}  // namespace lcrig
