// SPDX-License-Identifier: Apache-2.0
// The limit of a sequence of nested meshes, each finer than the one before. Used by the error
// estimates.
#pragma once

#include <vector>

namespace lcrig {

struct MeshLimit {
  double value = 0;  // Aitken's limit; the last value if the sequence has not settled
  double doubt = 0;  // possible error of the limit, if the order is the least to allow for
  double order = 0;  // observed, over the last steps; 0 when they change sign
  bool settled = false;  // each step is about half of the one before, or less
};

// The orders that the grading of a family gives to the worst corner, where the displacement goes
// like the root of the distance. One belongs to the direction that is graded less, one to the
// direction that is graded more. Coarse meshes may show a higher order by chance. The doubt
// therefore relies on `least` only, and a step that falls faster than `most` is assumed to be small
// by chance.
struct CornerOrders {
  double least, most;
};
inline constexpr double kLeastOrder = 1;  // each halving of the cells at least halves the error

// What is known of the meshes before they are solved.
struct MeshSequence {
  CornerOrders orders;
  std::vector<double> halvings;  // halvings of each cell, from each mesh to the next
};

// `values` from coarse to fine, at least three; only the last four count.
MeshLimit limit_of(const std::vector<double>& values, const MeshSequence& meshes);

}  // namespace lcrig
