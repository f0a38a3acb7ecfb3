// SPDX-License-Identifier: Apache-2.0
// How hard the specimen can push back, bounded from above: specimen and frame in series, each as
// stiff as it may be. Plan and run reckon with it how far the force rises while the frame stops.
#pragma once

#include <functional>
#include <limits>
#include <vector>

namespace lcrig {

// Travel beyond contact under a force, m: 0 at 0, rising. Empty: does not give way at all.
using Compression = std::function<double(double force_N)>;

class ForceBound {
 public:
  // `specimen_m`: its shortening, at least; it is tabulated here. With neither of the two nothing
  // bounds the force: every way ends at an infinite one.
  explicit ForceBound(const Compression& specimen_m,
                      double frame_stiffness_N_m = std::numeric_limits<double>::infinity());

  // Also known: this stiffness at this force, and that it is nowhere more than growth(force) times
  // as much. The smaller of both holds.
  void limit_to(double stiffness_N_m, const std::function<double(double force_N)>& growth);

  bool is_bounded() const;
  // The largest that a contact can have at this force, N/m.
  double stiffness_N_m(double force_N) const;
  // Force at the end of a way towards the specimen. Not k times the way: the contact stiffens.
  double force_after_N(double force_N, double way_m) const;
  // The largest force from which `way_m` leads to no more than `force_N`; 0 when even the whole
  // compression is shorter.
  double force_before_N(double force_N, double way_m) const;
  // Least way from one force to a larger one.
  double way_m(double from_N, double to_N) const;

 private:
  std::vector<double> stiffness_;  // of each cell of the force grid, N/m
};

}  // namespace lcrig
